//! Bounded waits, serial ports, and HTTP as a host uses them.

use http_body_util::{BodyExt, Empty};
use hyper::body::{Bytes, Incoming};
use hyper_util::rt::TokioIo;
use std::future::Future;
use std::path::Path;
use std::time::Duration;
use tokio_serial::{SerialPortBuilderExt, SerialStream};
use trunnion_protocol::mtconnect::{Document, parse};

/// No wait of a test is longer.
pub const BOUND: Duration = Duration::from_secs(20);

pub async fn bounded<T>(what: &str, future: impl Future<Output = T>) -> T {
    tokio::time::timeout(BOUND, future).await.unwrap_or_else(|_| panic!("{what}: nothing within {BOUND:?}"))
}

/// Opens a port as the drivers do, once it is there.
pub async fn open(port: &Path) -> SerialStream {
    bounded("opening the port", async {
        loop {
            match tokio_serial::new(port.to_string_lossy(), 921_600).open_native_async() {
                Ok(stream) => return stream,
                Err(_) => tokio::time::sleep(Duration::from_millis(5)).await,
            }
        }
    })
    .await
}

pub async fn get(url: &str, path: &str) -> hyper::Response<Incoming> {
    bounded(path, async {
        let host = url.strip_prefix("http://").unwrap();
        let stream = loop {
            match tokio::net::TcpStream::connect(host).await {
                Ok(stream) => break stream,
                Err(_) => tokio::time::sleep(Duration::from_millis(5)).await,
            }
        };
        let (mut sender, connection) =
            hyper::client::conn::http1::handshake(TokioIo::new(stream)).await.unwrap();
        tokio::spawn(connection);
        let request = hyper::Request::get(path).header("Host", host).body(Empty::<Bytes>::new()).unwrap();
        sender.send_request(request).await.unwrap()
    })
    .await
}

pub async fn document(url: &str, path: &str) -> Document {
    let body = bounded(path, get(url, path).await.into_body().collect()).await.unwrap().to_bytes();
    parse(&body).unwrap()
}
