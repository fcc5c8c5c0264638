//! Stopping a long kernel before its end.
//!
//! A kernel that can run for longer than a second takes an [`Interrupt`] and calls
//! [`Interrupt::check`] every few milliseconds of work at the latest; where that is an error, it
//! returns the error. Whoever calls the kernel says whether it shall stop: the Python binding
//! answers with the signals that are pending, so that Ctrl-C works.

use crate::error::{Error, Result};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::ThreadId;
use std::time::Instant;

/// Milliseconds between two questions.
const INTERVAL: u64 = 100;

/// Whether a kernel shall stop.
pub struct Interrupt<'a>(Option<Asking<'a>>);

struct Asking<'a> {
    ask: &'a (dyn Fn() -> bool + Sync),
    /// The thread that made the interrupt. It alone asks: signals reach one thread of a process,
    /// and a question may need a lock that the others should not wait for.
    asker: ThreadId,
    begin: Instant,
    /// When to ask again, in milliseconds after `begin`.
    next: AtomicU64,
    stopped: AtomicBool,
}

impl<'a> Interrupt<'a> {
    /// Never stops a kernel.
    pub const fn never() -> Self {
        Self(None)
    }

    /// Stops a kernel after `ask` has answered `true`. It is asked about every 100 ms, on the thread
    /// that calls this function.
    pub fn new(ask: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self(Some(Asking {
            ask,
            asker: std::thread::current().id(),
            begin: Instant::now(),
            next: AtomicU64::new(INTERVAL),
            stopped: AtomicBool::new(false),
        }))
    }

    /// Whether to go on. A call costs some tens of nanoseconds, and nothing for
    /// [`Interrupt::never`].
    ///
    /// # Errors
    /// [`Error::Interrupted`] from the moment on when the kernel shall stop, on every thread.
    #[inline]
    pub fn check(&self) -> Result<()> {
        self.0.as_ref().map_or(Ok(()), Asking::check)
    }
}

impl Asking<'_> {
    fn check(&self) -> Result<()> {
        if !self.stopped.load(Ordering::Relaxed) && self.is_due() && (self.ask)() {
            self.stopped.store(true, Ordering::Relaxed);
        }
        if self.stopped.load(Ordering::Relaxed) { Err(Error::Interrupted) } else { Ok(()) }
    }

    fn is_due(&self) -> bool {
        let now = self.begin.elapsed().as_millis() as u64;
        let due =
            now >= self.next.load(Ordering::Relaxed) && std::thread::current().id() == self.asker;
        if due {
            self.next.store(now + INTERVAL, Ordering::Relaxed);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn what_was_stopped_stays_stopped_on_every_thread() {
        let asked = AtomicU64::new(0);
        let ask = || asked.fetch_add(1, Ordering::Relaxed) == 1;
        let interrupt = Interrupt::new(&ask);
        let begin = Instant::now();
        while interrupt.check().is_ok() {
            assert!(begin.elapsed() < Duration::from_secs(60));
        }
        assert!(begin.elapsed() >= Duration::from_millis(2 * INTERVAL));
        assert_eq!(asked.load(Ordering::Relaxed), 2);
        let elsewhere = std::thread::scope(|s| s.spawn(|| interrupt.check()).join());
        assert_eq!(elsewhere.unwrap(), Err(Error::Interrupted));
    }

    #[test]
    fn other_threads_do_not_ask() {
        let interrupt = Interrupt::new(&|| true);
        std::thread::sleep(Duration::from_millis(2 * INTERVAL));
        let elsewhere = std::thread::scope(|s| s.spawn(|| interrupt.check()).join());
        assert_eq!(elsewhere.unwrap(), Ok(()));
        assert_eq!(interrupt.check(), Err(Error::Interrupted));
        assert_eq!(Interrupt::never().check(), Ok(()));
    }
}
