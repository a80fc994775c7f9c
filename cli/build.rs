//! Puts the page that `web/` builds into the program, if it is built: a list of its files, each with its bytes.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
};

fn main() -> io::Result<()> {
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let web = here.join("../web");
    let dist = web.join("dist");
    let mut files = Vec::new();
    if dist.is_dir() {
        find(&dist, &mut files)?;
        println!("cargo::rerun-if-changed={}", dist.display());
    } else if web.is_dir() {
        // What is not there cannot be watched: cargo would compile everything again each time.
        println!("cargo::rerun-if-changed={}", web.display());
    }
    println!("cargo::rerun-if-changed=build.rs");
    files.sort();
    let mut list = "[\n".to_owned();
    for file in files {
        let inside = file.strip_prefix(&dist).map_err(io::Error::other)?;
        let names: Vec<_> = inside.iter().map(|part| part.to_string_lossy()).collect();
        let bytes = file.to_str();
        let bytes = bytes.ok_or_else(|| io::Error::other("a path that is not UTF-8"))?;
        list += &format!(
            "    File {{ name: {:?}, bytes: include_bytes!({bytes:?}) }},\n",
            names.join("/")
        );
    }
    list += "]\n";
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(out.join("page.rs"), list)
}

fn find(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            find(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}
