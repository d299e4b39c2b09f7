//! Work on many cells, or other things of one kind, by as many threads as there are cores.

use std::{
    iter,
    num::NonZero,
    panic,
    sync::atomic::{AtomicUsize, Ordering},
    thread,
};

/// What `work` makes of each item, in their order.
pub fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let n_threads = thread::available_parallelism().map_or(1, NonZero::get).min(items.len());
    let next = AtomicUsize::new(0);
    let some = || {
        let items =
            iter::from_fn(|| items.iter().enumerate().nth(next.fetch_add(1, Ordering::Relaxed)));
        items.map(|(i, item)| (i, work(item))).collect::<Vec<_>>()
    };
    let mut all = thread::scope(|scope| {
        let threads: Vec<_> = (1..n_threads).map(|_| scope.spawn(some)).collect();
        let mut all = some();
        for thread in threads {
            match thread.join() {
                Ok(results) => all.extend(results),
                Err(cause) => panic::resume_unwind(cause),
            }
        }
        all
    });
    all.sort_by_key(|&(i, _)| i);
    all.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_items() {
        for n in [0, 1, 2, 1000] {
            let items: Vec<u64> = (0..n).collect();
            assert!(map(&items, |item| item * item).into_iter().eq(items.iter().map(|i| i * i)));
        }
    }
}
