//! Runs a browser that opens a page and reports the page's result.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A file that a page may request: path, type, bytes.
pub type Served<'a> = (&'a str, &'a str, &'a [u8]);

/// Finds the browser; prints a notice and returns `None` if there is none.
///
/// # Panics
/// If there is none, and `CI` is set.
pub fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let is_there = |name: &&str| Command::new(name).arg("--version").output().is_ok();
    let found = names.into_iter().find(is_there);
    if found.is_none() {
        let missing = "not run in a browser: there is no chromium (Debian: chromium)";
        assert!(std::env::var_os("CI").is_none(), "{missing}");
        eprintln!("{missing}");
    }
    found
}

/// Opens the served file `/`; returns the text that its script sends to `/said`.
///
/// # Panics
/// If the browser does not start, or does not answer within a minute.
pub fn said(browser: &str, arguments: &[&str], files: &[Served<'_>]) -> String {
    let server = TcpListener::bind("127.0.0.1:0").expect("a port is free");
    let port = server.local_addr().expect("the server has an address").port();
    let profile = std::env::temp_dir().join(format!("sinew-browser-{}-{port}", std::process::id()));
    let mut running = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-background-networking", "--no-first-run"])
        .args(["--remote-debugging-port=0", &format!("--user-data-dir={}", profile.display())])
        .args(arguments)
        .arg(format!("http://127.0.0.1:{port}/"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the browser starts");
    server.set_nonblocking(true).expect("the server can be non-blocking");
    // A browser that does not answer must not block the tests.
    let start = Instant::now();
    let mut said = None;
    while said.is_none() && start.elapsed() < Duration::from_secs(60) {
        match server.accept() {
            Ok((stream, _)) => said = answer(stream, files),
            Err(_) => std::thread::sleep(Duration::from_millis(10)),
        }
    }
    let _ = running.kill();
    let _ = running.wait();
    let _ = std::fs::remove_dir_all(profile);
    said.expect("the browser answers within a minute")
}

/// Answers a request with a file; returns the body of a request to `/said`.
fn answer(mut stream: TcpStream, files: &[Served<'_>]) -> Option<String> {
    stream.set_nonblocking(false).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(30))).ok()?;
    let mut lines = BufReader::new(stream.try_clone().ok()?);
    let (mut line, mut len, mut asked) = (String::new(), 0, String::new());
    while lines.read_line(&mut line).ok()? > 2 {
        if asked.is_empty() {
            asked.clone_from(&line);
        }
        let header = line.to_ascii_lowercase();
        len =
            header.strip_prefix("content-length:").map_or(Some(len), |n| n.trim().parse().ok())?;
        line.clear();
    }
    let mut body = vec![0; len];
    lines.read_exact(&mut body).ok()?;
    let path = asked.split(' ').nth(1)?;
    let (status, kind, content) = match files.iter().find(|(own, ..)| *own == path) {
        Some((_, kind, content)) => ("200 OK", *kind, *content),
        None => ("404 Not Found", "text/plain", &[][..]),
    };
    let head = format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nConnection: close");
    write!(stream, "{head}\r\nContent-Length: {}\r\n\r\n", content.len()).ok()?;
    stream.write_all(content).ok()?;
    asked.starts_with("POST").then(|| String::from_utf8_lossy(&body).into_owned())
}
