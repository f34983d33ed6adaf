//! A server for a browser of this machine: a thread for each connection, and bounds for all that it can take.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Result, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};
use std::thread::{Builder, sleep};
use std::time::Duration;

/// Connections at a time. The oldest makes room for a new one: of those that have asked nothing, if there are any.
const MOST_CONNECTIONS: usize = 64;
/// \[byte\] Of a request; what follows its head is not read.
const LARGEST_HEAD: usize = 16_384;
/// Longest time for the next part of a request to come, and for the next part of an answer to be taken.
const PATIENCE: Duration = Duration::from_secs(10);
/// Until it is looked again for a connection.
const PAUSE: Duration = Duration::from_millis(10);
/// Kinds of errors that say that nobody asks.
const NOTHING: [ErrorKind; 3] = [ErrorKind::WouldBlock, ErrorKind::Interrupted, ErrorKind::ConnectionAborted];

/// A request.
pub struct HttpRequest<'a> {
    pub method: &'a str,
    /// The path of the address, with what follows `?`.
    pub path: &'a str,
    pub host: &'a str,
    /// Whether it takes an answer that is compressed with gzip.
    pub takes_gzip: bool,
}

/// An answer.
pub struct HttpResponse {
    pub status: &'static str,
    /// Lines of the head, each with its end.
    pub head: String,
    pub content: Cow<'static, [u8]>,
}

struct Connection {
    stream: TcpStream,
    /// Whether it gets an answer by now.
    has_asked: AtomicBool,
}

/// Answers each connection once, as long as it `goes_on`. No connection waits for another one. Where no more files can be
/// open, or no thread can be had, the oldest connection ends, one without a request first, and the next one waits.
///
/// # Errors
/// The listener cannot be used.
pub fn serve(
    listener: &TcpListener,
    goes_on: impl Fn() -> bool,
    answer: impl Fn(&HttpRequest) -> HttpResponse + Sync,
) -> Result<()> {
    listener.set_nonblocking(true)?;
    let answer = &answer;
    // The newest connections. Their threads alone keep them open: an answered one takes no descriptor.
    let mut newest: VecDeque<Weak<Connection>> = VecDeque::new();
    let close =
        |connection: Weak<Connection>| connection.upgrade().map(|it| it.stream.shutdown(Shutdown::Both));
    let is_idle = |connection: &Weak<Connection>| {
        connection.upgrade().is_some_and(|it| !it.has_asked.load(Ordering::Relaxed))
    };
    std::thread::scope(|scope| {
        while goes_on() {
            newest.retain(|connection| connection.strong_count() > 0);
            let begun = listener.accept().and_then(|(stream, _)| {
                let connection = Arc::new(Connection { stream, has_asked: AtomicBool::new(false) });
                let kept = Arc::downgrade(&connection);
                Builder::new().spawn_scoped(scope, move || serve_one(&connection, answer))?;
                Ok(kept)
            });
            let is_full = match begun {
                Ok(connection) => {
                    newest.push_back(connection);
                    newest.len() > MOST_CONNECTIONS
                }
                Err(error) => {
                    sleep(PAUSE);
                    !NOTHING.contains(&error.kind())
                }
            };
            if is_full {
                let first = newest.iter().position(is_idle).unwrap_or(0);
                newest.remove(first).map(close);
            }
        }
        newest.into_iter().for_each(|connection| drop(close(connection)));
    });
    Ok(())
}

/// Reads a request, and sends the answer.
fn serve_one(connection: &Connection, answer: &impl Fn(&HttpRequest) -> HttpResponse) -> Result<()> {
    let mut stream = &connection.stream;
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let (mut request, mut part) = (Vec::new(), [0; 4096]);
    let end = loop {
        match stream.read(&mut part)? {
            0 => return Ok(()),
            length => request.extend_from_slice(&part[..length]),
        }
        if let Some(end) = request.windows(4).position(|end| end == b"\r\n\r\n") {
            break end;
        }
        if request.len() > LARGEST_HEAD {
            return stream.shutdown(Shutdown::Both);
        }
    };
    connection.has_asked.store(true, Ordering::Relaxed);
    let text = String::from_utf8_lossy(&request[..end]);
    let request = request_of(&text);
    let HttpResponse { status, head, content } = answer(&request);
    let length = content.len();
    let head = format!("HTTP/1.1 {status}\r\nContent-Length: {length}\r\nConnection: close\r\n{head}\r\n");
    stream.write_all(head.as_bytes())?;
    if request.method != "HEAD" {
        stream.write_all(&content)?;
    }
    stream.shutdown(Shutdown::Both)
}

/// Returns the request of a head; empty texts where it says nothing.
fn request_of(head: &str) -> HttpRequest<'_> {
    let mut lines = head.split("\r\n");
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (method, path) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let field = |wanted: &str| {
        let mut fields = lines.clone().filter_map(|line| line.split_once(':'));
        fields.find(|(name, _)| name.eq_ignore_ascii_case(wanted)).map_or("", |(_, value)| value.trim())
    };
    let is_gzip = |coding: &str| {
        let (name, weight) = coding.split_once(';').unwrap_or((coding, ""));
        // A weight of zero refuses it.
        let refused = weight.trim().strip_prefix("q=").and_then(|q| q.parse().ok()) == Some(0.0);
        name.trim().eq_ignore_ascii_case("gzip") && !refused
    };
    let takes_gzip = field("accept-encoding").split(',').any(is_gzip);
    HttpRequest { method, path, host: field("host"), takes_gzip }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    /// \[byte\] More than a connection takes that nobody reads from.
    const LARGE: usize = 64_000_000;

    /// Returns the answer of a server that repeats what was asked.
    fn told(asked: &mut TcpStream, text: &str) -> String {
        asked.write_all(text.as_bytes()).unwrap();
        let mut answer = String::new();
        asked.read_to_string(&mut answer).unwrap();
        answer
    }

    /// Without bounds there would be no thread for a connection at some time.
    #[test]
    fn connections_that_ask_nothing_or_too_much_keep_nobody_else_waiting() {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let (address, over) = (listener.local_addr().unwrap(), AtomicBool::new(false));
        let echo = |request: &HttpRequest| HttpResponse {
            status: "200 OK",
            head: "X-Lab: here\r\n".to_owned(),
            content: match request.path {
                "/large" => Cow::Owned(vec![b'x'; LARGE]),
                path => Cow::Owned(format!("{} {path} {}", request.method, request.host).into_bytes()),
            },
        };
        std::thread::scope(|scope| {
            let server = scope.spawn(|| serve(&listener, || !over.load(Ordering::Relaxed), echo));
            let connect = || TcpStream::connect(address).unwrap();
            // Who gets an answer is not closed for those who ask nothing.
            let mut taking = connect();
            taking.write_all(b"GET /large HTTP/1.1\r\n\r\n").unwrap();
            taking.read_exact(&mut [0; 1]).unwrap();
            let idle: Vec<TcpStream> = (0..3 * MOST_CONNECTIONS).map(|_| connect()).collect();
            let answer = told(&mut connect(), "GET /a?b HTTP/1.1\r\nhOsT:  me \r\nHost: other\r\n\r\n");
            let (head, content) = answer.split_once("\r\n\r\n").unwrap();
            assert!(
                head.starts_with("HTTP/1.1 200 OK\r\nContent-Length: 11\r\n")
                    && head.ends_with("X-Lab: here")
            );
            assert_eq!(content, "GET /a?b me");
            // A request in parts, one without an end, and no request at all.
            let mut slow = connect();
            slow.write_all(b"HEAD / HTTP/1.1\r\nHo").unwrap();
            let mut endless = connect();
            let written = (0..).find_map(|_| endless.write_all(&[b'x'; 4096]).err());
            assert!(written.is_some(), "it is closed");
            assert!(told(&mut connect(), "\r\n\r\n").ends_with("\r\n\r\n  "));
            let answer = told(&mut slow, "st: me\r\n\r\n");
            assert!(answer.contains("Content-Length: 9\r\n") && answer.ends_with("\r\n\r\n"), "{answer}");
            // Who takes an answer slowly keeps nobody waiting, and gets all of it.
            let mut slow = connect();
            slow.write_all(b"GET /large HTTP/1.1\r\n\r\n").unwrap();
            assert!(told(&mut connect(), "GET /a HTTP/1.1\r\n\r\n").ends_with("GET /a "));
            let mut large = Vec::new();
            slow.read_to_end(&mut large).unwrap();
            assert!(large.len() > LARGE && large.ends_with(b"xxx"), "{}", large.len());
            let mut rest = Vec::new();
            taking.read_to_end(&mut rest).unwrap();
            assert!(rest.len() > LARGE, "{}", rest.len());
            // The oldest of those who asked nothing have been closed.
            let mut oldest = &idle[0];
            assert_eq!(oldest.read(&mut [0; 1]).unwrap(), 0);
            over.store(true, Ordering::Relaxed);
            server.join().unwrap().unwrap();
        });
    }
}
