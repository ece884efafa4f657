//! A pseudo-terminal under a stable name, raw, with the device at the master side.
//!
//! One slave descriptor stays open here, so that the master is not hung up between two users of the port. Closing
//! the master hangs up the users: they read end of file and cannot write.

use nix::fcntl::{FcntlArg, FdFlag, OFlag, fcntl};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::termios::{FlushArg, SetArg, cfmakeraw, tcflush, tcgetattr, tcsetattr};
use std::fs;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::path::{Path, PathBuf};
use tokio::io::unix::AsyncFd;

#[derive(Debug)]
pub(super) struct Pty {
    master: AsyncFd<OwnedFd>,
    slave: OwnedFd,
    name: PathBuf,
}

impl Pty {
    /// A new pseudo-terminal that `name` links to; a link of that name is replaced.
    pub fn open(name: &Path) -> io::Result<Self> {
        let pair = nix::pty::openpty(None, None)?;
        let mut settings = tcgetattr(&pair.slave)?;
        cfmakeraw(&mut settings);
        tcsetattr(&pair.slave, SetArg::TCSANOW, &settings)?;
        for end in [&pair.master, &pair.slave] {
            // A child process that inherits the master would keep the port alive after it is unplugged.
            fcntl(end, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC))?;
        }
        let flags = OFlag::from_bits_retain(fcntl(&pair.master, FcntlArg::F_GETFL)?);
        fcntl(&pair.master, FcntlArg::F_SETFL(flags | OFlag::O_NONBLOCK))?;
        let target = nix::unistd::ttyname(&pair.slave)?;
        let staged = name.with_extension("new");
        remove_if_there(&staged)?;
        std::os::unix::fs::symlink(target, &staged)?;
        fs::rename(&staged, name)?;
        Ok(Self { master: register(pair.master)?, slave: pair.slave, name: name.to_owned() })
    }

    /// Bytes from the user of the port. Cancel safe.
    pub async fn read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let mut ready = self.master.readable().await?;
            match ready.try_io(|master| Ok(nix::unistd::read(master, buffer)?)) {
                Ok(result) => return result,
                Err(_not_ready) => {}
            }
        }
    }

    /// Writes what the kernel takes at once and says how much that is.
    pub fn write_now(&self, bytes: &[u8]) -> io::Result<usize> {
        let mut written = 0;
        while written < bytes.len() {
            match nix::unistd::write(self.master.get_ref(), &bytes[written..]) {
                Ok(count) => written += count,
                Err(nix::Error::EAGAIN) => break,
                Err(nix::Error::EINTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(written)
    }

    /// True while the user has not read everything written.
    pub fn has_unread(&self) -> io::Result<bool> {
        let mut slave = [PollFd::new(self.slave.as_fd(), PollFlags::POLLIN)];
        poll(&mut slave, PollTimeout::ZERO)?;
        Ok(slave[0].revents().is_some_and(|events| events.contains(PollFlags::POLLIN)))
    }

    /// Throws away what the user has not read.
    pub fn discard_unread(&self) -> io::Result<()> {
        Ok(tcflush(&self.slave, FlushArg::TCIFLUSH)?)
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        if let Err(error) = remove_if_there(&self.name) {
            tracing::warn!(%error, port = %self.name.display(), "the link of a closed port stays behind");
        }
    }
}

#[expect(
    deprecated,
    reason = "the successor is unsafe for descriptors that can be swapped; an OwnedFd stays open until it is dropped"
)]
fn register(master: OwnedFd) -> io::Result<AsyncFd<OwnedFd>> {
    AsyncFd::new(master)
}

fn remove_if_there(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        result => result,
    }
}
