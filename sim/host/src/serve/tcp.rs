//! Clients over TCP.

use super::client::{Connection, LINES, PIECES, read_all, write_all};
use std::io;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::mpsc::{Sender, sync_channel};
use std::thread;
use std::time::Duration;

/// Clients at once; one more is turned away.
const CLIENTS_MAX: usize = 32;
/// After a connection that could not be taken, for want of handles, say.
const PAUSE: Duration = Duration::from_millis(100);

/// Listens at `address` and hands every connection to `door`; the address that it really is.
pub(super) fn listen(address: SocketAddr, door: Sender<Connection>) -> io::Result<SocketAddr> {
    let listener = TcpListener::bind(address)?;
    let address = listener.local_addr()?;
    thread::spawn(move || {
        let connected = Arc::new(());
        loop {
            let Ok((stream, from)) = listener.accept() else {
                thread::sleep(PAUSE);
                continue;
            };
            // One is the listener's own; who is one too many finds the connection closed again.
            if Arc::strong_count(&connected) > CLIENTS_MAX {
                continue;
            }
            if let Ok(connection) = attach(stream, from, &connected)
                && door.send(connection).is_err()
            {
                return;
            }
        }
    });
    Ok(address)
}

/// A thread that reads and one that writes, so that a client which does neither holds up nobody.
fn attach(stream: TcpStream, from: SocketAddr, connected: &Arc<()>) -> io::Result<Connection> {
    // Lines are short, and answers are waited for.
    stream.set_nodelay(true)?;
    let (to_hub, incoming) = sync_channel(PIECES);
    let (outgoing, lines) = sync_channel(LINES);
    let (reader, writer) = (stream.try_clone()?, stream);
    let connected = Arc::clone(connected);
    thread::spawn(move || {
        read_all(&reader, &to_hub);
        // Ends the writer, too, if it waits for a client that reads nothing.
        let _ = reader.shutdown(Shutdown::Both);
        drop(connected);
    });
    thread::spawn(move || write_all(&writer, &lines));
    Ok(Connection { name: from.to_string(), incoming, outgoing })
}
