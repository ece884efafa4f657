//! Ports of the service: page, MTConnect adapter, OPC UA server. Measuring goes on without them.

use crate::board::Board;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;
use tracing::warn;

/// How often an address is tried that another program has. It costs nothing, and a person who ends that program looks at once.
const AGAIN: Duration = Duration::from_secs(1);

/// Listens at the address as soon as that can be had, and says on the board under this name why it cannot; `None` after `cancel`.
pub(super) async fn listening(
    name: &'static str,
    address: SocketAddr,
    board: &Board,
    cancel: &CancellationToken,
) -> Option<TcpListener> {
    let mut reported = String::new();
    loop {
        match TcpListener::bind(address).await {
            Ok(listener) => {
                board.set_connection(name, "");
                return Some(listener);
            }
            Err(error) => {
                let why = format!("{address} cannot be listened on: {error}");
                if why != reported {
                    warn!("[{name}]: {why}");
                    board.set_connection(name, &why);
                    reported = why;
                }
            }
        }
        tokio::select! {
            () = cancel.cancelled() => return None,
            () = tokio::time::sleep(AGAIN) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_port_of_another_program_stands_on_the_board_and_is_taken_when_it_is_free() {
        let other = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let (address, board) = (other.local_addr().unwrap(), Board::default());
        let of_task = board.clone();
        let taken =
            tokio::spawn(
                async move { listening("opcua", address, &of_task, &CancellationToken::new()).await },
            );
        let until = async |is_taken: bool| {
            let seen = async {
                while board.connections().get("opcua").is_none_or(|why| why.is_empty() == is_taken) {
                    tokio::task::yield_now().await;
                }
            };
            tokio::time::timeout(Duration::from_secs(20), seen).await.expect("it is said");
            board.connections()["opcua"].clone()
        };
        let why = until(true).await;
        assert!(why.contains(&address.to_string()) && why.contains("cannot be listened on"), "{why}");
        drop(other);
        assert_eq!(until(false).await, "");
        assert_eq!(taken.await.unwrap().unwrap().local_addr().unwrap(), address);
    }
}
