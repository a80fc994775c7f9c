//! Writes the files of the table of load times into a folder, and prints each with the time that it may take.

use std::{env, fs, io, path::Path};

fn main() -> io::Result<()> {
    let folder = env::args().nth(1).ok_or_else(|| {
        io::Error::new(io::ErrorKind::InvalidInput, "usage: hostile_files FOLDER")
    })?;
    fs::create_dir_all(&folder)?;
    for file in wbqp_tests::hostile::files() {
        fs::write(Path::new(&folder).join(file.name), &file.text)?;
        println!("{}\t{}\t{}", file.name, file.seconds, file.text.len());
    }
    Ok(())
}
