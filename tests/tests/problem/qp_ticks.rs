//! Files of problems for programs in other languages: what is written is what is read.

use std::io::Cursor;

use wbqp_tests::{
    qp_sequences::{Demand, aerial, drifting, quadruped},
    qp_ticks::{Tick, read, write},
};

fn file(ticks: &[Tick]) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(&mut bytes, ticks).expect("memory takes everything");
    bytes
}

#[test]
fn problems_come_back_to_the_bit() {
    let problems = aerial(3, Demand::Swelling)
        .into_iter()
        .chain(quadruped(2, Demand::Steady(1.0)))
        .chain(drifting(2, 5, 2, 3, Demand::Steady(0.3)));
    let ticks: Vec<Tick> = problems
        .enumerate()
        .map(|(k, qp)| Tick {
            is_first: k % 2 == 0,
            qp,
        })
        .collect();
    let back = read(&mut Cursor::new(file(&ticks))).expect("is of the format");
    assert_eq!(back.len(), ticks.len());
    for (a, b) in ticks.iter().zip(&back) {
        assert_eq!(a.is_first, b.is_first);
        assert_eq!((a.qp.vars(), a.qp.rows()), (b.qp.vars(), b.qp.rows()));
        let lists = |t: &Tick| {
            let qp = &t.qp;
            let limits = [qp.row_lower(), qp.row_upper(), qp.lower(), qp.upper()];
            let all = [qp.h(), qp.g(), qp.a()].into_iter().chain(limits);
            all.flatten().map(|v| v.to_bits()).collect::<Vec<u64>>()
        };
        assert_eq!(lists(a), lists(b));
    }
}

#[test]
fn other_files_are_refused() {
    let ticks = [Tick {
        is_first: true,
        qp: drifting(1, 4, 1, 2, Demand::Swelling).remove(0),
    }];
    let good = file(&ticks);
    assert!(read(&mut Cursor::new(&good)).is_ok());
    assert!(
        read(&mut Cursor::new(&good[..good.len() - 1])).is_err(),
        "cut off"
    );
    assert!(
        read(&mut Cursor::new(b"WBQPTK02\0\0\0\0")).is_err(),
        "another format"
    );
    // n of the first problem.
    let mut large = good.clone();
    large[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(
        read(&mut Cursor::new(large)).is_err(),
        "more variables than there can be"
    );
    // Two rows with the same identity.
    let mut twice = good.clone();
    let ids = twice.len() - 4 * (4 + 3);
    twice.copy_within(ids..ids + 4, ids + 4);
    assert!(
        read(&mut Cursor::new(twice)).is_err(),
        "identities do not ascend"
    );
}
