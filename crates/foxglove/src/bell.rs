//! Wakes the network's thread, which waits for sockets.

use std::io::{self, Read as _, Write as _};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};

/// A bell between threads. Ringing it never waits, and costs no call of the system while it already rings.
pub(crate) struct Bell {
    ringing: AtomicBool,
    near: UnixStream,
    far: UnixStream,
}

impl Bell {
    pub fn new() -> io::Result<Self> {
        let (near, far) = UnixStream::pair()?;
        near.set_nonblocking(true)?;
        far.set_nonblocking(true)?;
        Ok(Self {
            ringing: AtomicBool::new(false),
            near,
            far,
        })
    }

    pub fn ring(&self) {
        if !self.ringing.swap(true, Ordering::SeqCst) {
            // It cannot fail: there is at most one byte on the way.
            let _ = (&self.near).write(&[1]);
        }
    }

    /// What to wait for.
    pub fn socket(&self) -> BorrowedFd<'_> {
        self.far.as_fd()
    }

    /// Silences the bell. Whatever was there before the ring is found by looking after this.
    pub fn heard(&self) {
        let mut rings = [0; 16];
        let _ = (&self.far).read(&mut rings);
        self.ringing.store(false, Ordering::SeqCst);
    }
}
