//! `lemons lab`: gives the lab's page to the browser of this machine.
//!
//! It answers this machine only, and only requests that name it as their host: a page of another place cannot ask it,
//! whatever name it gives this machine. It gives away the files that were built into this program, and the libraries
//! that the page packs into FMUs.

mod server;

use crate::interrupt::Interrupt;
use crate::print;
use anyhow::{Context, Result, bail};
use crowd_mechanics::pack::{Binary, THIRD_PARTY};
use flate2::read::GzDecoder;
use lemons_core::files::input;
use server::{HttpRequest, HttpResponse, serve};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::process::{Command, Stdio};

include!(concat!(env!("OUT_DIR"), "/lab.rs"));

/// The policy of the page itself.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; connect-src 'self'; \
     worker-src 'self'; img-src 'self' blob:; base-uri 'none'; form-action 'none'";
/// Rest of the policy, but for the address `?embed`, which shows the stage alone: no other page may show this one in a
/// frame.
const NO_FRAME: &str = "; frame-ancestors 'none'";

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
    let libraries = libraries();
    let interrupt = Interrupt::watch();
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, arguments.port))
        .with_context(|| format!("cannot listen on port {}", arguments.port))?;
    let address = listener.local_addr()?;
    let url = format!("http://{address}/");
    let mut out = print::out();
    writeln!(out, "the lab is at {url}, until Ctrl-C")?;
    out.flush()?;
    if !arguments.no_browser
        && let Err(error) = open_browser(&url)
    {
        note!("no browser could be opened: {error}");
    }
    let answered = |request: &HttpRequest| answer(request, address, &libraries);
    serve(&listener, || !interrupt.pressed(), answered).context("the lab takes no more connections")
}

/// Starts the browser that this machine opens addresses with, and does not wait for it.
fn open_browser(url: &str) -> std::io::Result<()> {
    let (program, arguments): (_, &[&str]) = match std::env::consts::OS {
        "windows" => ("rundll32", &["url.dll,FileProtocolHandler"]),
        "macos" => ("open", &[]),
        _ => ("xdg-open", &[]),
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().map(drop)
}

/// The crowd's libraries, and their licences: platform -> path in the page's address, and file.
type Libraries = BTreeMap<String, (String, PathBuf)>;

/// Returns those beside this program. Without them, the page says that it makes no FMUs.
fn libraries() -> Libraries {
    let found = lemons_master::binaries_beside("crowd_mechanics", &[]).unwrap_or_default();
    let licences = found.first().and_then(Binary::third_party);
    let licences = licences.map(|path| (THIRD_PARTY.to_owned(), (format!("binaries/{THIRD_PARTY}"), path)));
    let place = |Binary { platform, path }: Binary| {
        let place = format!("binaries/{platform}/{}", path.file_name()?.to_str()?);
        Some((platform, (place, path)))
    };
    found.into_iter().filter_map(place).chain(licences).collect()
}

fn answer(request: &HttpRequest, address: SocketAddr, libraries: &Libraries) -> HttpResponse {
    let here = [address.to_string(), format!("localhost:{}", address.port())];
    let (path, query) = request.path.split_once('?').unwrap_or((request.path, ""));
    let path = if path == "/" { "index.html" } else { path.trim_start_matches('/') };
    let mut encoding = "";
    let (status, kind, content): (_, _, Cow<'static, [u8]>) = if here.iter().all(|here| here != request.host)
    {
        ("403 Forbidden", "txt", b"another host".into())
    } else if !matches!(request.method, "GET" | "HEAD") {
        ("405 Method Not Allowed", "txt", b"only GET and HEAD".into())
    } else if let Some((name, content)) =
        FILES.iter().find(|(name, _)| name.strip_suffix(".gz").unwrap_or(name) == path)
    {
        let content = if !name.ends_with(".gz") {
            Cow::Borrowed(*content)
        } else if request.takes_gzip {
            encoding = "Content-Encoding: gzip\r\n";
            Cow::Borrowed(*content)
        } else {
            let mut whole = Vec::new();
            // The file was made with this program: it is whole.
            let _ = GzDecoder::new(*content).read_to_end(&mut whole);
            whole.into()
        };
        ("200 OK", path.rsplit('.').next().unwrap_or_default(), content)
    } else if path == "binaries.json" {
        let places: BTreeMap<_, _> = libraries.iter().map(|(name, (place, _))| (name, place)).collect();
        ("200 OK", "json", serde_json::to_vec(&places).unwrap_or_default().into())
    } else {
        let file = libraries.values().find(|(place, _)| place == path);
        match file.map(|(_, file)| input::read(file, input::LARGEST_BINARY)) {
            Some(Ok(content)) => ("200 OK", "so", content.into()),
            // Perhaps too many files are open.
            Some(Err(error)) => ("503 Service Unavailable", "txt", error.to_string().into_bytes().into()),
            None => ("404 Not Found", "txt", b"there is no such file".into()),
        }
    };
    let frame = if query == "embed" { "" } else { NO_FRAME };
    let head = format!(
        "Content-Type: {}\r\nContent-Security-Policy: {POLICY}{frame}\r\nX-Content-Type-Options: nosniff\r\n\
         Referrer-Policy: no-referrer\r\nCache-Control: no-cache\r\nVary: Accept-Encoding\r\n\
         {encoding}",
        kind_of(kind)
    );
    HttpResponse { status, head, content }
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
