//! One pool of threads of our own, and how wide it may be.
//!
//! Linux forks: a child inherits the pool's memory but not its threads, and work handed to it
//! would wait for ever; so would a lock that another thread of the parent held at that moment.
//! Each process of a line of forks therefore has a place of its own, with a lock of its own, and
//! never touches those of its parents; in a child the first parallel call builds a new pool.
//!
//! Work is split over frames, runs or matrices only and every item writes its own place of the
//! output, so that a result has the same bits with one thread or with many.

use crate::error::Result;
use crate::interrupt::Interrupt;
use rayon::ThreadPool;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::Duration;

/// How long the calling thread of [`fill_until`] sleeps between two looks for an interrupt.
const PATIENCE: Duration = Duration::from_millis(20);

/// 0 stands for "as many as the machine has".
static THREADS: AtomicUsize = AtomicUsize::new(0);
/// Asked once, since the answer takes tens of microseconds to find; 0 where it was not asked yet.
static MACHINE: AtomicUsize = AtomicUsize::new(0);
/// Most forks in one line, each made by a child of the one before, that have a pool of their own.
const GENERATIONS: usize = 64;
static PLACES: [Place; GENERATIONS] = [const { Place::new() }; GENERATIONS];

/// Where one process keeps its pool.
struct Place {
    /// Whose it is; 0 for a free place.
    process: AtomicU32,
    pool: Mutex<Option<Pool>>,
}

impl Place {
    const fn new() -> Self {
        Self { process: AtomicU32::new(0), pool: Mutex::new(None) }
    }

    /// Whether it is this process's, which it becomes where it was free.
    fn belongs_to(&self, process: u32) -> bool {
        let owner = self.process.compare_exchange(0, process, Ordering::Relaxed, Ordering::Relaxed);
        owner.is_ok() || owner == Err(process)
    }
}

struct Pool {
    threads: usize,
    pool: Arc<ThreadPool>,
}

/// Lets kernels use at most this many threads; 0 for as many as the machine has.
pub fn set_threads(threads: usize) {
    THREADS.store(threads, Ordering::Relaxed);
}

/// How many threads a kernel may use.
pub fn threads() -> usize {
    match THREADS.load(Ordering::Relaxed) {
        0 => machine(),
        threads => threads,
    }
}

/// How many threads the machine has. Two that ask at once find the same.
fn machine() -> usize {
    match MACHINE.load(Ordering::Relaxed) {
        0 => {
            let found = std::thread::available_parallelism().map_or(1, usize::from);
            MACHINE.store(found, Ordering::Relaxed);
            found
        }
        known => known,
    }
}

/// The pool of this process, or `None` where one thread is all there is to be had.
fn pool() -> Option<Arc<ThreadPool>> {
    let (threads, process) = (threads(), std::process::id());
    if threads < 2 {
        return None;
    }
    let place = PLACES.iter().find(|place| place.belongs_to(process))?;
    let mut slot = lock(&place.pool);
    if let Some(pool) = slot.as_ref().filter(|pool| pool.threads == threads) {
        return Some(Arc::clone(&pool.pool));
    }
    let pool = Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()?);
    *slot = Some(Pool { threads, pool: Arc::clone(&pool) });
    Some(pool)
}

/// Cuts `output` into consecutive pieces of at least `least` items and fills each by
/// `fill(first, piece)`, in parallel where there is more than one piece and more than one thread.
///
/// The first error in the order of the items is returned, whichever thread met it.
pub fn fill<T, E, F>(output: &mut [T], least: usize, fill: F) -> std::result::Result<(), E>
where
    T: Send,
    E: Send,
    F: Fn(usize, &mut [T]) -> std::result::Result<(), E> + Sync,
{
    match pieces(output.len(), least) {
        None => fill(0, output),
        Some((pool, size)) => share_pieces(&pool, output, size, &fill),
    }
}

/// [`fill`] for what may take long: the thread that calls it looks for interrupts while others
/// work.
///
/// `fill` itself passes `interrupt.check()?` as often as a kernel on one thread would.
///
/// # Errors
/// The first error in the order of the items.
pub fn fill_until<T, F>(
    output: &mut [T],
    least: usize,
    interrupt: &Interrupt<'_>,
    fill: F,
) -> Result<()>
where
    T: Send,
    F: Fn(usize, &mut [T]) -> Result<()> + Sync,
{
    let Some((pool, size)) = pieces(output.len(), least) else {
        return fill(0, output);
    };
    let mut result = Ok(());
    pool.in_place_scope(|scope| {
        let (done, wait) = mpsc::channel::<()>();
        let (result, fill, workers) = (&mut result, &fill, &*pool);
        scope.spawn(move |_| {
            *result = share_pieces(workers, output, size, fill);
            drop(done);
        });
        while wait.recv_timeout(PATIENCE) == Err(mpsc::RecvTimeoutError::Timeout) {
            // The workers ask again and take the error home.
            let _ = interrupt.check();
        }
    });
    result
}

/// The pool and the size of a piece, or `None` where one thread does it all.
fn pieces(items: usize, least: usize) -> Option<(Arc<ThreadPool>, usize)> {
    let pieces = (items / least.max(1)).min(4 * threads());
    if pieces < 2 {
        return None;
    }
    Some((pool()?, items.div_ceil(pieces)))
}

/// As many threads as allowed, the calling one among them, take piece after piece.
///
/// One more than is needed is woken, and the last to come finds no seat: a system that wakes a
/// thread on the processor of its caller may leave it waiting there for milliseconds.
fn share_pieces<T, E, F>(
    pool: &ThreadPool,
    output: &mut [T],
    size: usize,
    fill: &F,
) -> std::result::Result<(), E>
where
    T: Send,
    E: Send,
    F: Fn(usize, &mut [T]) -> std::result::Result<(), E> + Sync,
{
    let pieces = Mutex::new(output.chunks_mut(size).enumerate());
    let first_error: Mutex<Option<(usize, E)>> = Mutex::new(None);
    let work = || {
        // Not in the head of the loop: the lock would be held while the piece is filled.
        let next = || lock(&pieces).next();
        while let Some((i, piece)) = next() {
            if let Err(error) = fill(i * size, piece) {
                let mut first = lock(&first_error);
                if first.as_ref().is_none_or(|(earliest, _)| i < *earliest) {
                    *first = Some((i, error));
                }
            }
        }
    };
    let (threads, seats) = (pool.current_num_threads(), AtomicUsize::new(1));
    pool.in_place_scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|_| {
                if seats.fetch_add(1, Ordering::Relaxed) < threads {
                    work();
                }
            });
        }
        work();
    });
    let found = first_error.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.map_or(Ok(()), |(_, error)| Err(error))
}

/// What a mutex holds; a thread that panicked leaves nothing half written in those of this file.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_filled_once_and_the_first_error_wins() {
        for n in [0, 1, 7, 1000] {
            let mut output = vec![0usize; n];
            fill::<_, (), _>(&mut output, 10, |first, piece| {
                piece.iter_mut().enumerate().for_each(|(i, x)| *x += first + i);
                Ok(())
            })
            .unwrap();
            assert!(output.iter().enumerate().all(|(i, &x)| i == x));
        }
        let failed = fill(&mut [0u8; 1000], 10, |first, piece| {
            (first + piece.len() <= 300).then_some(()).ok_or(first)
        });
        assert!(failed.is_err_and(|first| first <= 300));
    }

    #[test]
    fn a_child_never_waits_for_what_its_parent_held() {
        let places = [const { Place::new() }; 3];
        let mine = |process| places.iter().position(|place| place.belongs_to(process));
        assert_eq!([mine(7), mine(7)], [Some(0); 2]);
        let _held = lock(&places[0].pool);
        assert_eq!([mine(8), mine(9), mine(8), mine(10)], [Some(1), Some(2), Some(1), None]);
        assert!(lock(&places[1].pool).is_none());
    }

    #[test]
    fn the_calling_thread_stops_the_others() {
        use crate::error::Error;
        let asker = std::thread::current().id();
        let ask = || std::thread::current().id() == asker;
        let interrupt = Interrupt::new(&ask);
        let stopped = fill_until(&mut [0u8; 8], 1, &interrupt, |_, _| {
            loop {
                interrupt.check()?;
            }
        });
        assert_eq!(stopped, Err(Error::Interrupted));
    }
}
