//! A server for a browser of this machine: one thread, and bounds for all that a connection can take.

use std::borrow::Cow;
use std::io::{ErrorKind, Read, Result, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Connections at a time. The oldest makes room for a new one.
const MOST_CONNECTIONS: usize = 64;
/// \[byte\] Of a request; what follows its head is not read.
const LARGEST_HEAD: usize = 16_384;
/// Longest time for a request to come, and for the next part of an answer to be taken.
const PATIENCE: Duration = Duration::from_secs(10);

/// A request.
pub struct Request<'a> {
    pub method: &'a str,
    /// The path of the address, with what follows `?`.
    pub path: &'a str,
    pub host: &'a str,
}

/// An answer.
pub struct Answer {
    pub status: &'static str,
    /// Lines of the head, each with its end.
    pub head: String,
    pub content: Cow<'static, [u8]>,
}

/// A connection, from its first byte to the last one of its answer.
struct Connection {
    stream: TcpStream,
    /// When something came or was taken last.
    since: Instant,
    request: Vec<u8>,
    /// Head and content; empty as long as the request is not complete.
    answer: [Cow<'static, [u8]>; 2],
    sent: usize,
}

/// Answers, each connection once, as long as it goes on. No connection waits for another one.
///
/// # Errors
/// No connection can be taken.
pub fn serve(
    listener: &TcpListener,
    goes_on: impl Fn() -> bool,
    answer: impl Fn(&Request) -> Answer,
) -> Result<()> {
    listener.set_nonblocking(true)?;
    let mut all: Vec<Connection> = Vec::new();
    while goes_on() {
        match listener.accept() {
            Ok((stream, _)) if stream.set_nonblocking(true).is_ok() => {
                if all.len() == MOST_CONNECTIONS {
                    all.remove(0);
                }
                all.push(Connection::new(stream));
            }
            // Who asked is gone.
            Ok(_) => {}
            Err(error) if is_nothing(error.kind()) || error.kind() == ErrorKind::ConnectionAborted => {}
            Err(error) if all.is_empty() => return Err(error),
            // Perhaps too many files are open.
            Err(_) => drop(all.remove(0)),
        }
        all.retain_mut(|connection| connection.goes_on(&answer).unwrap_or(false));
        sleep(Duration::from_millis(if all.is_empty() { 20 } else { 2 }));
    }
    Ok(())
}

fn is_nothing(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

impl Connection {
    fn new(stream: TcpStream) -> Connection {
        let answer = [Cow::default(), Cow::default()];
        Connection { stream, since: Instant::now(), request: Vec::new(), answer, sent: 0 }
    }

    /// Reads what has come, and sends what is taken. Returns whether there is more to do.
    fn goes_on(&mut self, answer: impl Fn(&Request) -> Answer) -> Result<bool> {
        let moved = if self.answer[0].is_empty() { self.receive(answer) } else { self.send() };
        match moved {
            Ok(0) => Ok(false),
            Ok(_) => Ok(true),
            Err(error) if is_nothing(error.kind()) => Ok(self.since.elapsed() < PATIENCE),
            Err(error) => Err(error),
        }
    }

    /// Reads a part of the request; when it is complete, it is answered.
    fn receive(&mut self, answer: impl Fn(&Request) -> Answer) -> Result<usize> {
        let mut part = [0; 4096];
        let length = self.stream.read(&mut part)?;
        self.request.extend_from_slice(&part[..length]);
        if let Some(end) = self.request.windows(4).position(|end| end == b"\r\n\r\n") {
            let text = String::from_utf8_lossy(&self.request[..end]);
            let request = request_of(&text);
            let Answer { status, head, content } = answer(&request);
            let head = format!(
                "HTTP/1.1 {status}\r\nContent-Length: {}\r\nConnection: close\r\n{head}\r\n",
                content.len()
            );
            let content = if request.method == "HEAD" { Cow::default() } else { content };
            (self.answer, self.since) = ([Cow::Owned(head.into_bytes()), content], Instant::now());
        } else if self.request.len() > LARGEST_HEAD {
            return Ok(0);
        }
        Ok(length)
    }

    /// Sends the next part of the answer; nothing is left after the last one.
    fn send(&mut self) -> Result<usize> {
        let [head, content] = &self.answer;
        let rest = head.get(self.sent..).filter(|rest| !rest.is_empty());
        let rest = rest.unwrap_or_else(|| &content[self.sent - head.len()..]);
        let length = self.stream.write(rest)?;
        (self.sent, self.since) = (self.sent + length, Instant::now());
        Ok(length)
    }
}

/// Returns the request of a head; empty texts where it says nothing.
fn request_of(head: &str) -> Request<'_> {
    let mut lines = head.split("\r\n");
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (method, path) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let mut fields = lines.filter_map(|line| line.split_once(':'));
    let host = fields.find(|(name, _)| name.eq_ignore_ascii_case("host"));
    Request { method, path, host: host.map_or("", |(_, value)| value.trim()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// \[byte\] More than a connection takes that nobody reads from.
    const LARGE: usize = 64_000_000;

    /// Returns the answer of a server that repeats what was asked.
    fn told(asked: &mut TcpStream, text: &str) -> String {
        asked.write_all(text.as_bytes()).unwrap();
        let mut answer = String::new();
        asked.read_to_string(&mut answer).unwrap();
        answer
    }

    /// A thread was made for each connection; where none could be had, nobody was answered any more.
    #[test]
    fn connections_that_ask_nothing_or_too_much_keep_nobody_else_waiting() {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let (address, over) = (listener.local_addr().unwrap(), AtomicBool::new(false));
        let echo = |request: &Request| Answer {
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
            // The oldest of those who asked nothing have been closed.
            let mut oldest = &idle[0];
            assert_eq!(oldest.read(&mut [0; 1]).unwrap(), 0);
            over.store(true, Ordering::Relaxed);
            server.join().unwrap().unwrap();
        });
    }
}
