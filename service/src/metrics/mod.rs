//! An HTTP endpoint for Prometheus: `GET /metrics`, and nothing else. It asks the physics what `report/latest` asks, and
//! not more often than the rates of the report change, whoever asks here.

mod text;

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use anyhow::anyhow;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Mutex, Semaphore, oneshot};
use tokio::task::AbortHandle;
use tokio::time::{Instant, timeout};

use crate::intake::Io;
use crate::mailbox::{Letter, Read, ReadAnswer};

/// Between two questions to the physics.
const FRESH: Duration = Duration::from_millis(200);
/// Connections at a time; others wait until one is free.
const CONNECTIONS: usize = 16;
/// For one connection, from its first byte to its last.
const PATIENCE: Duration = Duration::from_secs(5);
/// Longest request line and headers, bytes.
const LONGEST_REQUEST: usize = 8192;
/// Prometheus' format.
const CONTENT: &str = "text/plain; version=0.0.4; charset=utf-8";

/// A socket that listens, and answers once it is told whom to ask.
pub struct Endpoint {
    listener: TcpListener,
    /// With the port that was chosen where 0 was asked for.
    pub address: SocketAddr,
}

impl Endpoint {
    /// Listens.
    ///
    /// # Errors
    /// The address is taken, or is not one of this machine.
    pub async fn open(address: SocketAddr) -> std::io::Result<Self> {
        let listener = TcpListener::bind(address).await?;
        Ok(Self { address: listener.local_addr()?, listener })
    }

    /// Answers until the task is aborted.
    pub(crate) fn spawn(self, io: Arc<Io>) -> AbortHandle {
        let page = Arc::new(Page { io, newest: Mutex::new(None) });
        tokio::spawn(accept(self.listener, page)).abort_handle()
    }
}

/// The answer, kept for a moment.
struct Page {
    io: Arc<Io>,
    newest: Mutex<Option<(Instant, Arc<str>)>>,
}

impl Page {
    /// All metrics, at most [`FRESH`] old. Who comes while the physics is asked waits for the same answer.
    async fn read(&self) -> anyhow::Result<Arc<str>> {
        let mut newest = self.newest.lock().await;
        if let Some((asked, text)) = &*newest
            && asked.elapsed() < FRESH
        {
            return Ok(Arc::clone(text));
        }
        let (sender, receiver) = oneshot::channel();
        let delivered = self.io.mailbox.deliver(Letter::Read(Read::Report, sender));
        delivered.map_err(|_| anyhow!("the daemon is busy or ending"))?;
        let ReadAnswer::Report(sample) = receiver.await? else {
            return Err(anyhow!("the physics has no report"));
        };
        let report = self.io.identity.report(&sample, 0);
        let text: Arc<str> = text::encode(&self.io.identity.scene_info(), &report).into();
        *newest = Some((Instant::now(), Arc::clone(&text)));
        Ok(text)
    }
}

async fn accept(listener: TcpListener, page: Arc<Page>) {
    let open = Arc::new(Semaphore::new(CONNECTIONS));
    while let Ok(permit) = Arc::clone(&open).acquire_owned().await {
        match listener.accept().await {
            Ok((stream, _)) => {
                let page = Arc::clone(&page);
                tokio::spawn(async move {
                    if !matches!(timeout(PATIENCE, converse(stream, &page)).await, Ok(Ok(()))) {
                        tracing::debug!("a connection to the metrics was cut off");
                    }
                    drop(permit);
                });
            }
            Err(error) => {
                tracing::warn!("metrics: {error}");
                // Out of files, probably: trying again at once would only burn time.
                tokio::time::sleep(FRESH).await;
            }
        }
    }
}

/// One request, one answer.
async fn converse(mut stream: TcpStream, page: &Page) -> std::io::Result<()> {
    let (status, kind, body) = match read_head(&mut stream).await?.as_deref().map(target) {
        Some(Ok("/metrics")) => match page.read().await {
            Ok(text) => ("200 OK", CONTENT, text),
            Err(error) => ("503 Service Unavailable", "text/plain", format!("{error}\n").into()),
        },
        Some(Ok(_)) => ("404 Not Found", "text/plain", "there is /metrics only\n".into()),
        Some(Err(Refused::Method)) => ("405 Method Not Allowed", "text/plain", "only GET is allowed\n".into()),
        Some(Err(Refused::Malformed)) | None => {
            let text = format!("not a request of HTTP/1 with at most {LONGEST_REQUEST} bytes before its body\n");
            ("400 Bad Request", "text/plain", text.into())
        }
    };
    let allow = if status.starts_with("405") { "Allow: GET\r\n" } else { "" };
    let length = body.len();
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{allow}Connection: close\r\n\r\n"
    );
    stream.write_all(head.as_bytes()).await?;
    stream.write_all(body.as_bytes()).await?;
    stream.shutdown().await?;
    // What is left unread would reset the connection before the answer is read.
    let mut rest = stream.take(LONGEST_REQUEST as u64);
    tokio::io::copy(&mut rest, &mut tokio::io::sink()).await?;
    Ok(())
}

/// Request line and headers; nothing where they do not end, or are too long.
async fn read_head(stream: &mut TcpStream) -> std::io::Result<Option<Vec<u8>>> {
    let mut head = Vec::with_capacity(1024);
    let mut limited = stream.take(LONGEST_REQUEST as u64);
    while limited.read_buf(&mut head).await? > 0 {
        if head.windows(4).any(|four| four == b"\r\n\r\n") {
            return Ok(Some(head));
        }
    }
    Ok(None)
}

/// Why a request has no target.
#[derive(Debug, PartialEq, Eq)]
enum Refused {
    Malformed,
    Method,
}

/// What a request asks for, without its parameters.
fn target(head: &[u8]) -> Result<&str, Refused> {
    let line = head.split(|&byte| byte == b'\r').next().unwrap_or_default();
    let line = std::str::from_utf8(line).map_err(|_| Refused::Malformed)?;
    match line.split(' ').collect::<Vec<_>>()[..] {
        [method, target, "HTTP/1.1" | "HTTP/1.0"] if target.starts_with('/') => {
            let path = target.split('?').next().unwrap_or_default();
            if method == "GET" { Ok(path) } else { Err(Refused::Method) }
        }
        _ => Err(Refused::Malformed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_strictly() {
        assert_eq!(target(b"GET /metrics HTTP/1.1\r\nHost: a\r\n\r\n"), Ok("/metrics"));
        assert_eq!(target(b"GET /metrics?a=b HTTP/1.0\r\n\r\n"), Ok("/metrics"));
        assert_eq!(target(b"POST /metrics HTTP/1.1\r\n\r\n"), Err(Refused::Method));
        for malformed in [
            &b"GET /metrics\r\n\r\n"[..],
            b"GET  /metrics HTTP/1.1\r\n\r\n",
            b"GET a HTTP/1.1\r\n\r\n",
            b"\xff\r\n\r\n",
            b"\r\n\r\n",
        ] {
            assert_eq!(target(malformed), Err(Refused::Malformed), "{malformed:?}");
        }
    }
}
