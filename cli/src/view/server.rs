//! Serves the page and one log on the loopback address.

use std::{
    collections::BTreeMap,
    io::{self, Cursor, Read},
    net::{Ipv4Addr, SocketAddr},
    thread,
};

use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use tiny_http::{Header, Method, Request, Response, StatusCode};

use super::{log_file::LogFile, page::File};

/// Requests that are answered at a time: a browser asks for several files at once, and a long log takes its time.
const THREADS: usize = 4;

/// What is behind a name.
#[derive(Clone)]
enum Resource {
    Page(File),
    Log,
}

/// Answers GET and HEAD of the page's files and of one log. All names are known beforehand: nothing of a request ever
/// becomes a path.
pub(crate) struct Server {
    http: tiny_http::Server,
    port: u16,
    /// By path, as it stands in a request.
    resources: BTreeMap<String, Resource>,
    log: LogFile,
    /// Path of the log, without the first slash.
    log_path: String,
}

type Answer = Response<Box<dyn Read + Send>>;

impl Server {
    /// A server on a port of 127.0.0.1; a free one if it is 0.
    ///
    /// # Errors
    /// A port that is taken or not allowed.
    pub(crate) fn bind(port: u16, page: &[File], log: LogFile) -> io::Result<Self> {
        let http = tiny_http::Server::http(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))
            .map_err(io::Error::other)?;
        let address = http.server_addr().to_ip();
        let port = address.map_or(port, |address| address.port());
        let log_path = format!("log/{}", encoded(&log.name()));
        let mut resources = BTreeMap::new();
        for file in page {
            resources.insert(format!("/{}", file.name), Resource::Page(*file));
            if file.name == "index.html" {
                resources.insert("/".to_owned(), Resource::Page(*file));
            }
        }
        resources.insert(format!("/{log_path}"), Resource::Log);
        Ok(Self {
            http,
            port,
            resources,
            log,
            log_path,
        })
    }

    /// Where a browser finds the page with the log.
    pub(crate) fn address(&self) -> String {
        let log = encoded(&self.log_path);
        format!("http://127.0.0.1:{}/?log={log}", self.port)
    }

    /// Answers until [`Self::stop`].
    pub(crate) fn serve(&self) {
        thread::scope(|scope| {
            for _ in 0..THREADS {
                scope.spawn(|| {
                    for request in self.http.incoming_requests() {
                        let answer = self.answer(&request);
                        // Whoever asked is gone: nobody is left to be told.
                        let _ = request.respond(answer);
                    }
                });
            }
        });
    }

    fn answer(&self, request: &Request) -> Answer {
        if !self.is_meant(request) {
            return words(403, "this server answers requests to 127.0.0.1 alone\n");
        }
        if !matches!(request.method(), Method::Get | Method::Head) {
            let refusal = words(405, "only GET and HEAD are answered\n");
            return with(refusal, "Allow", "GET, HEAD");
        }
        let path = request.url().split(['?', '#']).next().unwrap_or_default();
        match self.resources.get(path) {
            Some(Resource::Page(file)) => {
                let length = Some(file.bytes.len());
                bytes(200, file.content_type(), Cursor::new(file.bytes), length)
            }
            Some(Resource::Log) => self.log(),
            None => words(404, "there is nothing of this name\n"),
        }
    }

    /// Whether this machine's name for itself was asked: the page of another host whose name leads here must not read
    /// the log.
    fn is_meant(&self, request: &Request) -> bool {
        let mut headers = request.headers().iter();
        let host = headers.find(|header| header.field.equiv("Host"));
        host.is_some_and(|header| {
            let host = header.value.as_str();
            let (name, port) = host.rsplit_once(':').unwrap_or((host, "80"));
            matches!(name, "127.0.0.1" | "localhost") && port.parse() == Ok(self.port)
        })
    }

    fn log(&self) -> Answer {
        match self.log.open() {
            // No more than there is now: a run may be writing. Its length is not promised: it may begin again, too.
            Ok((file, length)) => bytes(200, "application/octet-stream", file.take(length), None),
            Err(error) => {
                let code = match error.kind() {
                    io::ErrorKind::NotFound => 404,
                    _ => 500,
                };
                words(code, &format!("{error}\n"))
            }
        }
    }

    /// Ends [`Self::serve`].
    #[cfg(test)]
    fn stop(&self) {
        (0..THREADS).for_each(|_| self.http.unblock());
    }
}

fn encoded(text: &str) -> String {
    utf8_percent_encode(text, NON_ALPHANUMERIC).to_string()
}

fn words(code: u16, text: &str) -> Answer {
    let length = text.len();
    bytes(
        code,
        "text/plain; charset=utf-8",
        Cursor::new(text.to_owned()),
        Some(length),
    )
}

fn bytes(
    code: u16,
    content_type: &str,
    body: impl Read + Send + 'static,
    length: Option<usize>,
) -> Answer {
    let body: Box<dyn Read + Send> = Box::new(body);
    let answer = Response::new(StatusCode(code), Vec::new(), body, length, None);
    // A length that is known is told.
    let answer = answer.with_chunked_threshold(usize::MAX);
    let answer = with(answer, "Content-Type", content_type);
    let answer = with(answer, "X-Content-Type-Options", "nosniff");
    // Another program may have this port tomorrow, and the log may be another one at any time.
    with(answer, "Cache-Control", "no-store")
}

fn with(answer: Answer, field: &str, value: &str) -> Answer {
    match Header::from_bytes(field, value) {
        Ok(header) => answer.with_header(header),
        Err(()) => answer,
    }
}

#[cfg(test)]
mod tests {
    use std::{
        env, fs,
        io::{Read as _, Write as _},
        net::TcpStream,
        path::PathBuf,
        process,
    };

    use super::*;

    const PAGE: &[File] = &[
        File {
            name: "index.html",
            bytes: b"<p>page</p>",
        },
        File {
            name: "assets/a.wasm",
            bytes: b"\0asm",
        },
        File {
            name: "assets/a.js",
            bytes: b"1",
        },
    ];
    const LOG: &[u8] = b"\x89MCAP0\r\nand more";

    /// A file that goes away with its owner.
    struct Temporary(PathBuf);

    impl Drop for Temporary {
        fn drop(&mut self) {
            let _ = fs::remove_file(&self.0);
        }
    }

    /// Ends a server with its owner, also after an assertion that failed.
    struct Stop<'a>(&'a Server);

    impl Drop for Stop<'_> {
        fn drop(&mut self) {
            self.0.stop();
        }
    }

    /// Runs a test against a server with a log of this name.
    fn with_server(name: &str, test: impl FnOnce(&Server, &Temporary)) {
        let log = Temporary(env::temp_dir().join(format!("{}-{name}", process::id())));
        fs::write(&log.0, LOG).unwrap();
        let server = Server::bind(0, PAGE, LogFile::new(&log.0)).unwrap();
        thread::scope(|scope| {
            scope.spawn(|| server.serve());
            let _stop = Stop(&server);
            test(&server, &log);
        });
    }

    /// What comes back: status, head, body.
    fn ask_as(server: &Server, host: &str, method: &str, path: &str) -> (u16, String, String) {
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, server.port)).unwrap();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
        )
        .unwrap();
        let mut all = Vec::new();
        stream.read_to_end(&mut all).unwrap();
        let all = String::from_utf8_lossy(&all).into_owned();
        let (head, body) = all.split_once("\r\n\r\n").unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, head.to_lowercase(), body.to_owned())
    }

    fn ask(server: &Server, method: &str, path: &str) -> (u16, String, String) {
        let host = format!("127.0.0.1:{}", server.port);
        ask_as(server, &host, method, path)
    }

    /// The log's path in a request, from the address that is opened.
    fn log_path(server: &Server) -> String {
        format!("/{}", server.log_path)
    }

    #[test]
    fn the_page_has_its_files_with_their_types() {
        with_server("page.mcap", |server, _| {
            for (path, content_type, content) in [
                ("/", "text/html", "<p>page</p>"),
                ("/?log=x", "text/html", "<p>page</p>"),
                ("/index.html", "text/html", "<p>page</p>"),
                ("/assets/a.js", "text/javascript", "1"),
                ("/assets/a.wasm", "application/wasm", "\0asm"),
            ] {
                let (status, head, body) = ask(server, "GET", path);
                assert_eq!((status, body.as_str()), (200, content), "{path}");
                assert!(
                    head.contains(&format!("content-type: {content_type}")),
                    "{head}"
                );
                assert!(
                    head.contains(&format!("content-length: {}", content.len())),
                    "{head}"
                );
                let (status, _, body) = ask(server, "HEAD", path);
                assert_eq!((status, body.as_str()), (200, ""), "{path}");
            }
        });
    }

    #[test]
    fn other_names_are_not_found_however_they_are_written() {
        with_server("names.mcap", |server, _| {
            for path in [
                "/nothing",
                "/assets",
                "/assets/",
                "/assets/../index.html",
                "/../Cargo.toml",
                "/..%2f..%2fetc/passwd",
                "/log/../../../../etc/passwd",
                "/log/%2e%2e/Cargo.toml",
                "//etc/passwd",
                "/log/",
                "/log/other.mcap",
            ] {
                assert_eq!(ask(server, "GET", path).0, 404, "{path}");
            }
        });
    }

    #[test]
    fn nothing_but_get_and_head_is_answered() {
        with_server("methods.mcap", |server, _| {
            for method in ["POST", "PUT", "DELETE", "OPTIONS", "PATCH"] {
                let (status, head, _) = ask(server, method, "/");
                assert_eq!(status, 405, "{method}");
                assert!(head.contains("allow: get, head"), "{head}");
            }
        });
    }

    #[test]
    fn a_host_that_leads_here_under_another_name_gets_nothing() {
        with_server("hosts.mcap", |server, _| {
            let (status, _, body) = ask_as(server, "example.org", "GET", &log_path(server));
            assert_eq!(status, 403);
            assert!(!body.contains("MCAP"));
            let other = format!("127.0.0.1:{}", server.port ^ 1);
            assert_eq!(ask_as(server, &other, "GET", "/").0, 403);
            let local = format!("localhost:{}", server.port);
            assert_eq!(ask_as(server, &local, "GET", "/").0, 200);
        });
    }

    #[test]
    fn the_log_is_read_at_each_request() {
        with_server("a run, 50 % & ü.mcap", |server, log| {
            let path = log_path(server);
            let (status, head, body) = ask(server, "GET", &path);
            assert_eq!(status, 200);
            assert!(
                head.contains("content-type: application/octet-stream"),
                "{head}"
            );
            assert!(body.contains("and more"), "{body}");
            fs::write(&log.0, [LOG, b" than before"].concat()).unwrap();
            assert!(ask(server, "GET", &path).2.contains("more than before"));
            assert_eq!(ask(server, "HEAD", &path).0, 200);
            fs::write(&log.0, "no log any more").unwrap();
            let (status, _, body) = ask(server, "GET", &path);
            assert_eq!(status, 500);
            assert!(body.contains("is no MCAP file"), "{body}");
            fs::remove_file(&log.0).unwrap();
            assert_eq!(ask(server, "GET", &path).0, 404);
            // And the page is still there.
            assert_eq!(ask(server, "GET", "/").0, 200);
        });
    }

    #[test]
    fn a_port_that_is_taken_is_refused() {
        with_server("port.mcap", |server, log| {
            assert!(Server::bind(server.port, PAGE, LogFile::new(&log.0)).is_err());
        });
    }
}
