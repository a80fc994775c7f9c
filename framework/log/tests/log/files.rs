//! Logs on a disk: short chunks, logs that were cut, and two runs that want the same file.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use mcap::{MessageStream, Summary};
use serde_json::json;
use wbqp_log::{LogError, LogSink, McapLog, repair};

/// A folder that goes away with its owner.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("wbqp_log_{name}_{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Four seconds at 100 Hz on two channels, with metadata and an attachment.
fn write(path: &Path) {
    let mut log = McapLog::create(path).unwrap();
    let table = BTreeMap::from([("key".to_owned(), "value".to_owned())]);
    log.metadata("table", &table).unwrap();
    log.attach("a.toml", "application/toml", b"a = 1").unwrap();
    let schema = json!({ "type": "object" });
    let a = log.channel("/a", "A", &schema).unwrap();
    let b = log.channel("/b", "B", &schema).unwrap();
    for k in 0..400 {
        let text = format!("{{\"k\":{k}}}");
        log.write(a, f64::from(k) * 0.01, text.as_bytes()).unwrap();
        log.write(b, f64::from(k) * 0.01, b"{}").unwrap();
    }
    log.finish().unwrap();
}

/// Topic, time in ns and text of every message.
fn messages(bytes: &[u8]) -> Vec<(String, u64, Vec<u8>)> {
    let all = MessageStream::new(bytes).unwrap().map(Result::unwrap);
    all.map(|m| (m.channel.topic.clone(), m.log_time, m.data.into_owned()))
        .collect()
}

#[test]
fn a_chunk_has_at_most_half_a_second() {
    let folder = Folder::new("chunks");
    let path = folder.file("a.mcap");
    write(&path);
    let summary = Summary::read(&fs::read(&path).unwrap()).unwrap().unwrap();
    assert_eq!(summary.chunk_indexes.len(), 8);
    for chunk in &summary.chunk_indexes {
        assert!(chunk.message_end_time - chunk.message_start_time < 500_000_000);
    }
}

#[test]
fn what_was_written_is_in_the_file_while_the_run_goes_on() {
    let folder = Folder::new("flushed");
    let path = folder.file("a.mcap");
    let mut log = McapLog::create(&path).unwrap();
    let channel = log.channel("/a", "A", &json!({})).unwrap();
    for k in 0..100 {
        log.write(channel, f64::from(k) * 0.01, b"{}").unwrap();
    }
    // As after `kill -9`: nothing is completed.
    let saved = folder.file("saved.mcap");
    let found = repair(&path, &saved).unwrap();
    assert!(!found.was_whole);
    assert_eq!((found.messages, found.end), (50, 0.49));
}

#[test]
fn a_log_that_is_cut_anywhere_is_saved_up_to_its_last_chunk() {
    let folder = Folder::new("cut");
    let path = folder.file("a.mcap");
    write(&path);
    let whole = fs::read(&path).unwrap();
    let all = messages(&whole);
    let chunks = Summary::read(&whole).unwrap().unwrap().chunk_indexes;
    let cut = folder.file("cut.mcap");
    let saved = folder.file("saved.mcap");
    for length in (8..whole.len()).step_by(97) {
        fs::write(&cut, &whole[..length]).unwrap();
        let found = repair(&cut, &saved).unwrap();
        let bytes = fs::read(&saved).unwrap();
        let is_there = |end: u64| end <= length as u64;
        let expected = chunks
            .iter()
            .filter(|chunk| is_there(chunk.chunk_start_offset + chunk.chunk_length))
            .count();
        // A hundred messages a chunk: fifty ticks on two channels.
        assert_eq!(messages(&bytes), all[..100 * expected], "{length} bytes");
        assert_eq!(found.messages as usize, 100 * expected);
        assert!(!found.was_whole);
        fs::remove_file(&saved).unwrap();
    }
    // Of a whole one nothing is lost, its tables and files neither.
    let found = repair(&path, &saved).unwrap();
    assert!(found.was_whole && found.lost == 0, "{found:?}");
    let bytes = fs::read(&saved).unwrap();
    assert_eq!(messages(&bytes), all);
    let summary = Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.metadata_indexes.len(), 1);
    assert_eq!(summary.attachment_indexes.len(), 1);
    assert_eq!(summary.schemas.len(), 2);
}

/// The channels of the second have the ids of the first's, whatever they are.
#[test]
fn of_two_logs_end_to_end_the_first_is_saved_and_the_second_is_told() {
    let folder = Folder::new("two");
    let path = folder.file("a.mcap");
    write(&path);
    let whole = fs::read(&path).unwrap();
    let (both, saved) = (folder.file("both.mcap"), folder.file("saved.mcap"));
    fs::write(&both, whole.repeat(2)).unwrap();
    let found = repair(&both, &saved).unwrap();
    assert!(
        messages(&fs::read(&saved).unwrap()) == messages(&whole),
        "{found:?}"
    );
    assert!(!found.was_whole && !found.is_index_alone, "{found:?}");
    let damage = found.damage.expect("is told");
    // Behind the end of the first there are the eight bytes with which it ends.
    assert_eq!(damage.at, whole.len() as u64 - 8);
    assert!(damage.what.contains("behind its end"), "{damage}");
    // Of one that is cut, up to its last chunk.
    fs::remove_file(&saved).unwrap();
    let cut = &whole[..whole.len() * 6 / 10];
    fs::write(&both, [cut, &whole].concat()).unwrap();
    let found = repair(&both, &saved).unwrap();
    let left = messages(&fs::read(&saved).unwrap());
    assert!(
        left.len() >= 300 && messages(&whole)[..left.len()] == left[..],
        "{found:?}"
    );
    assert!(
        !found.is_index_alone && found.messages_lost.is_none(),
        "{found:?}"
    );
}

/// Of four seconds on two channels: 800 messages in 8 chunks.
#[test]
fn of_a_log_with_a_bit_of_another_value_all_but_its_chunk_is_saved() {
    let folder = Folder::new("bits");
    let path = folder.file("a.mcap");
    write(&path);
    let whole = fs::read(&path).unwrap();
    wbqp_log::check(&whole).unwrap();
    let all = messages(&whole);
    let (damaged, saved) = (folder.file("damaged.mcap"), folder.file("saved.mcap"));
    let with_bit = |bit: usize| {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes
    };
    for bit in (64..8 * whole.len()).step_by(7) {
        assert!(wbqp_log::check(&with_bit(bit)).is_err(), "bit {bit}");
    }
    for bit in (64..8 * whole.len()).step_by(1009) {
        let bytes = with_bit(bit);
        fs::write(&damaged, &bytes).unwrap();
        let found = repair(&damaged, &saved).unwrap();
        assert!(!found.was_whole, "bit {bit}: {found:?}");
        let left = messages(&fs::read(&saved).unwrap());
        assert_eq!(found.messages as usize, left.len());
        assert!(left.len() >= 700, "bit {bit}: {found:?}");
        // What is saved is what was written, in its order.
        let mut written = all.iter();
        assert!(
            left.iter().all(|m| written.any(|w| w == m)),
            "bit {bit}: {found:?}"
        );
        if let Some(lost) = found.messages_lost {
            assert_eq!(lost as usize, 800 - left.len(), "bit {bit}");
        }
        if left.len() < 800 {
            let damage = found.damage.expect("is known");
            assert!(damage.at <= bit as u64 / 8 && !found.is_index_alone);
        }
        fs::remove_file(&saved).unwrap();
    }
}

fn record(kind: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![kind];
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(body);
    bytes
}

/// A chunk without compression and checksum, which says to be so long.
fn chunk(records: &[u8], length: u64) -> Vec<u8> {
    let mut body = vec![0; 16];
    body.extend(length.to_le_bytes());
    body.extend([0; 8]);
    body.extend((records.len() as u64).to_le_bytes());
    body.extend(records);
    record(6, &body)
}

#[test]
fn lengths_that_nothing_can_have_are_damage_and_no_panic() {
    let folder = Folder::new("lengths");
    let (path, to) = (folder.file("a.mcap"), folder.file("b.mcap"));
    let begin = [b"\x89MCAP0\r\n".as_slice(), &record(1, &[0; 8])].concat();
    let endless = [[5].as_slice(), &[0xff; 8], b"xx"].concat();
    // A text of 4 GB, and attachments without what they are made of.
    let text = [[0, 0].as_slice(), &u32::MAX.to_le_bytes(), b"s"].concat();
    for (what, bad) in [
        ("a record", endless.clone()),
        ("a record in a chunk", chunk(&endless, endless.len() as u64)),
        ("a chunk", chunk(b"", 1 << 62)),
        ("a schema", record(3, &text)),
        ("an attachment", record(9, b"ab")),
        ("an attachment's text", record(9, &[0xff; 40])),
    ] {
        let good = chunk(&record(5, &[0; 22]), 31);
        fs::write(&path, [begin.as_slice(), &bad, &good].concat()).unwrap();
        let found = repair(&path, &to).unwrap();
        let at = found.damage.as_ref().map(|damage| damage.at);
        assert_eq!(at, Some(begin.len() as u64), "{what}: {found:?}");
        assert!(!found.was_whole && !found.is_index_alone, "{what}");
        fs::remove_file(&to).unwrap();
    }
}

/// Each has a checksum of all that is before it.
#[test]
fn ends_of_the_data_again_and_again_take_no_time() {
    let ends = record(15, &[1; 4]).repeat(500_000);
    let bytes = [b"\x89MCAP0\r\n".as_slice(), &ends].concat();
    let folder = Folder::new("ends");
    let (path, to) = (folder.file("a.mcap"), folder.file("b.mcap"));
    fs::write(&path, bytes).unwrap();
    assert_eq!(repair(&path, &to).unwrap().damages, 500_000);
}

#[test]
fn what_is_no_log_is_not_repaired_and_nothing_is_written_over() {
    let folder = Folder::new("no_log");
    let (path, to) = (folder.file("a.mcap"), folder.file("b.mcap"));
    for text in ["", "a", "\u{89}MCAP1\r\n and more"] {
        fs::write(&path, text).unwrap();
        assert!(matches!(repair(&path, &to), Err(LogError::Read { .. })));
        assert!(!to.exists());
    }
    write(&to);
    fs::remove_file(&path).unwrap();
    write(&path);
    assert!(matches!(repair(&path, &to), Err(LogError::Create { .. })));
    assert!(matches!(repair(&path, &path), Err(LogError::Create { .. })));
}

#[test]
fn a_second_run_does_not_touch_the_log_of_the_first() {
    let folder = Folder::new("two");
    let path = folder.file("a.mcap");
    let mut first = McapLog::create(&path).unwrap();
    let channel = first.channel("/a", "A", &json!({})).unwrap();
    first.write(channel, 0.0, b"{}").unwrap();
    let error = McapLog::create(&path).expect_err("is taken");
    assert!(matches!(error, LogError::Taken { .. }));
    let words = error.to_string();
    let process = format!("process {}", std::process::id());
    assert!(words.contains(&process), "{words}");
    McapLog::create(&folder.file("b.mcap")).expect("another case is nobody's");
    first.finish().unwrap();
    assert_eq!(messages(&fs::read(&path).unwrap()).len(), 1);
    drop(first);
    McapLog::create(&path).expect("is free");
}
