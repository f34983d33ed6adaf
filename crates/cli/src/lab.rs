//! `lemons lab`: gives the lab's page to the browser of this machine.
//!
//! It answers this machine only, and only requests that name it as their host: a page of another place cannot ask it,
//! whatever name it gives this machine. It gives away the files that were built into this program, and the libraries
//! that the page packs into FMUs.

use crate::interrupt::Interrupt;
use crate::tell;
use anyhow::{Context, Result, anyhow, bail};
use crowd_mechanics::pack::{Binary, THIRD_PARTY};
use lemons_files::input;
use std::collections::BTreeMap;
use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;
use tiny_http::{Method, Request, Server};

include!(concat!(env!("OUT_DIR"), "/lab.rs"));

/// As the page itself says; and no other page may show this one in a frame.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; connect-src 'self'; \
     worker-src 'self'; img-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

#[derive(clap::Args)]
pub struct Arguments {
    /// Port on this machine; 0: any that is free
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,
    /// Print the address, but open no browser
    #[arg(long)]
    no_browser: bool,
}

pub fn lab(arguments: &Arguments) -> Result<()> {
    if FILES.is_empty() {
        bail!("this program was built without the lab: run lab/build.sh, then build it again (docs/lab.md)");
    }
    let libraries = Libraries::beside();
    let interrupt = Interrupt::watch();
    let server = Server::http((Ipv4Addr::LOCALHOST, arguments.port))
        .map_err(|error| anyhow!("cannot listen on port {}: {error}", arguments.port))?;
    let address = server.server_addr().to_ip().context("this machine gave no port")?;
    let url = format!("http://{address}/");
    let mut out = tell::out();
    writeln!(out, "the lab is at {url}, until Ctrl-C")?;
    out.flush()?;
    if !arguments.no_browser
        && let Err(error) = open::that_detached(&url)
    {
        note!("no browser could be opened: {error}");
    }
    while !interrupt.pressed() {
        if let Some(request) = server.recv_timeout(Duration::from_millis(100)).context("the lab")? {
            // Who asked is gone.
            let _ = answer(request, address, &libraries);
        }
    }
    Ok(())
}

/// The crowd's libraries and their licences: path in the page's address -> platform, file.
struct Libraries(BTreeMap<String, (String, PathBuf)>);

impl Libraries {
    /// Without them, the page says that it makes no FMUs.
    fn beside() -> Libraries {
        let found = lemons_master::binaries_beside("crowd_mechanics", &[]).unwrap_or_default();
        let licences = found.first().and_then(Binary::third_party);
        let place = |Binary { platform, path }: Binary| {
            let name = path.file_name()?.to_str()?;
            Some((format!("binaries/{platform}/{name}"), (platform, path)))
        };
        let licences =
            licences.map(|path| (format!("binaries/{THIRD_PARTY}"), (THIRD_PARTY.to_owned(), path)));
        Libraries(found.into_iter().filter_map(place).chain(licences).collect())
    }

    fn list(&self) -> String {
        let entries = self.0.iter().map(|(place, (name, _))| format!("{name:?}:{place:?}"));
        format!("{{{}}}", entries.collect::<Vec<_>>().join(","))
    }
}

fn answer(request: Request, address: SocketAddr, libraries: &Libraries) -> std::io::Result<()> {
    let host = request.headers().iter().find(|header| header.field.equiv("Host"));
    let host = host.map(|header| header.value.as_str().to_owned()).unwrap_or_default();
    let here = [address.to_string(), format!("localhost:{}", address.port())];
    let path = request.url().split(['?', '#']).next().unwrap_or_default();
    let path = if path == "/" { "index.html" } else { path.trim_start_matches('/') };
    let (status, kind, content) = if !here.contains(&host) {
        ("403 Forbidden", "txt", b"another host".to_vec())
    } else if !matches!(request.method(), Method::Get | Method::Head) {
        ("405 Method Not Allowed", "txt", b"only GET and HEAD".to_vec())
    } else if let Some((name, content)) = FILES.iter().find(|(name, _)| *name == path) {
        ("200 OK", name.rsplit('.').next().unwrap_or_default(), content.to_vec())
    } else if path == "binaries.json" {
        ("200 OK", "json", libraries.list().into_bytes())
    } else {
        let library = libraries.0.get(path).map(|(_, file)| input::read(file, input::LARGEST_BINARY));
        match library {
            Some(Ok(content)) => ("200 OK", "so", content),
            _ => ("404 Not Found", "txt", b"there is no such file".to_vec()),
        }
    };
    // Each connection is for one request: tiny_http may leave a request waiting while other connections are kept.
    let whole = *request.method() != Method::Head;
    let mut writer = request.into_writer();
    write!(
        writer,
        "HTTP/1.1 {status}\r\nContent-Type: {}\r\nContent-Length: {}\r\nContent-Security-Policy: {POLICY}\r\n\
         X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCache-Control: no-cache\r\n\
         Connection: close\r\n\r\n",
        kind_of(kind),
        content.len(),
    )?;
    if whole {
        writer.write_all(&content)?;
    }
    writer.flush()
}

fn kind_of(extension: &str) -> &'static str {
    match extension {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "svg" => "image/svg+xml",
        "wasm" => "application/wasm",
        "json" => "application/json",
        "txt" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}
