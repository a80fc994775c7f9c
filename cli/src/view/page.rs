//! The page, built into this program.

/// A file of the page.
#[derive(Clone, Copy, Debug)]
pub(crate) struct File {
    /// Its path below the page's folder, with `/`.
    pub(crate) name: &'static str,
    pub(crate) bytes: &'static [u8],
}

impl File {
    /// What a browser has to know of it.
    pub(crate) fn content_type(&self) -> &'static str {
        let ending = self.name.rsplit_once('.').map(|(_, ending)| ending);
        match ending {
            Some("html") => "text/html; charset=utf-8",
            // Browsers run no module of another type.
            Some("js") => "text/javascript; charset=utf-8",
            Some("css") => "text/css; charset=utf-8",
            Some("wasm") => "application/wasm",
            Some("svg") => "image/svg+xml",
            Some("json") => "application/json",
            _ => "application/octet-stream",
        }
    }
}

/// All files of the page; none if it was not built when this program was.
pub(crate) static FILES: &[File] = &include!(concat!(env!("OUT_DIR"), "/page.rs"));
