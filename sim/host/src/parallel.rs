//! Runs the same work for many items, on every core.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// Time that [`for_each`] waits for a result before it asks whether to go on.
const PATIENCE: Duration = Duration::from_millis(50);

/// As many threads as this program may run at once.
pub fn threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// `work` for every item, on every core, the results in the order of the items.
pub fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let mut results: Vec<(usize, R)> = Vec::with_capacity(items.len());
    for_each(
        items,
        threads(),
        |item, _| work(item),
        |finished| {
            results.extend(finished);
            true
        },
    );
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// `work` for every item on so many threads, which take the next item as they get free, because runs differ
/// in length. The caller's thread tells each result as it comes, with the index of its item, and `None` now
/// and then while there is none; when `tell` answers false, no further item is begun and the flag that `work`
/// is given is set.
pub fn for_each<T: Sync, R: Send>(
    items: &[T],
    threads: usize,
    work: impl Fn(&T, &AtomicBool) -> R + Sync,
    mut tell: impl FnMut(Option<(usize, R)>) -> bool,
) {
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (finished, results) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..threads.clamp(1, items.len().max(1)) {
            let (finished, next, stop, work) = (finished.clone(), &next, &stop, &work);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed)
                    && let index = next.fetch_add(1, Ordering::Relaxed)
                    && let Some(item) = items.get(index)
                    && finished.send((index, work(item, stop))).is_ok()
                {}
            });
        }
        drop(finished);
        loop {
            let go_on = match results.recv_timeout(PATIENCE) {
                Ok(result) => tell(Some(result)),
                Err(RecvTimeoutError::Timeout) => tell(None),
                Err(RecvTimeoutError::Disconnected) => return,
            };
            if !go_on {
                stop.store(true, Ordering::Relaxed);
                // Whoever sends now finds nobody, and ends.
                return;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..1000).collect();
        // The first are the slowest.
        let squares = map(&items, |item| {
            thread::sleep(Duration::from_micros(if *item < 10 { 2000 } else { 0 }));
            item * item
        });
        assert_eq!(squares, items.iter().map(|item| item * item).collect::<Vec<_>>());
        assert!(map(&[0_u8; 0], |item| *item).is_empty());
    }

    #[test]
    fn a_no_ends_what_runs_and_begins_nothing() {
        let begun = AtomicUsize::new(0);
        let mut told = 0;
        for_each(
            &[(); 100],
            2,
            |(), stop| {
                // The first ends at once, every other one only when it is told to.
                if begun.fetch_add(1, Ordering::Relaxed) > 0 {
                    while !stop.load(Ordering::Relaxed) {
                        thread::yield_now();
                    }
                }
            },
            |result| {
                told += usize::from(result.is_some());
                result.is_none()
            },
        );
        assert_eq!(told, 1);
        assert!(begun.into_inner() <= 3);
    }
}
