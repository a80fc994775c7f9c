//! Copies the scenarios that ship to where the wheel takes them from.

use std::{env, fs, io, path::Path};

fn main() -> io::Result<()> {
    let from = Path::new("../examples/scenarios");
    println!("cargo:rerun-if-changed={}", from.display());
    let to = Path::new(&env::var_os("OUT_DIR").unwrap_or_default()).join("scenarios");
    // What was taken away there is taken away here.
    let _ = fs::remove_dir_all(&to);
    fs::create_dir_all(&to)?;
    for file in fs::read_dir(from)? {
        let file = file?;
        println!("cargo:rerun-if-changed={}", file.path().display());
        fs::copy(file.path(), to.join(file.file_name()))?;
    }
    Ok(())
}
