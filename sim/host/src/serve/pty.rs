//! A client over a pseudo-terminal: a serial port for programs that know nothing else.

use super::client::{Connection, FromClient, LINES, PIECES, read_all, write_all};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::Duration;

/// Time for which a terminal that nobody has opened is left alone.
const PAUSE: Duration = Duration::from_millis(20);

/// The terminal's path. A link to it goes with it.
pub(super) struct Terminal {
    path: PathBuf,
    link: Option<PathBuf>,
}

/// Makes a terminal, and a symbolic link to it if one is asked for.
pub(super) fn open(link: Option<&Path>) -> io::Result<(Terminal, Connection)> {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    // Bytes as they are, and no echo, for clients that do not say so.
    let mut settings = tcgetattr(&master)?;
    settings.make_raw();
    tcsetattr(&master, OptionalActions::Now, &settings)?;
    let name = ptsname(&master, Vec::new())?;
    let path = PathBuf::from(OsStr::from_bytes(name.as_bytes()));
    let terminal = Terminal::linked(path, link)?;

    let reader = File::from(master);
    let writer = reader.try_clone()?;
    let (to_hub, incoming) = sync_channel(PIECES);
    let (outgoing, lines) = sync_channel(LINES);
    thread::spawn(move || {
        // Reading fails from when a client has closed the terminal until the next one opens it.
        loop {
            read_all(&reader, &to_hub);
            if to_hub.send(FromClient::HungUp).is_err() {
                return;
            }
            thread::sleep(PAUSE);
        }
    });
    thread::spawn(move || {
        // So does writing; what nobody receives is gone.
        while write_all(&writer, &lines).is_err() {}
    });
    Ok((terminal, Connection { name: "pty".into(), incoming, outgoing }))
}

impl Terminal {
    fn linked(path: PathBuf, link: Option<&Path>) -> io::Result<Self> {
        if let Some(link) = link {
            // One that an earlier drive has left behind may go, anything else may not.
            if link.is_symlink() {
                fs::remove_file(link)?;
            }
            symlink(&path, link)?;
        }
        Ok(Self { path, link: link.map(Path::to_owned) })
    }

    /// Returns the path that a client opens.
    pub(super) fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(&self.path)
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if let Some(link) = &self.link
            && fs::read_link(link).is_ok_and(|target| target == self.path)
        {
            let _ = fs::remove_file(link);
        }
    }
}
