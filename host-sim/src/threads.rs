//! The threads to compute on.

use rayon::{ThreadBuilder, ThreadPoolBuilder};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, available_parallelism};

/// Makes as many as are wanted, or as there are processors, or, where the system allows no more, fewer. What
/// is computed does not depend on it. Called once.
pub fn begin(wanted: Option<usize>) {
    let wanted = wanted.unwrap_or_else(|| available_parallelism().map_or(1, usize::from));
    let (give, take) = channel::<ThreadBuilder>();
    let take = Arc::new(Mutex::new(take));
    // Made first and handed to the pool after, which panics if it is refused one.
    let made = (0..wanted).take_while(|_| {
        let take = Arc::clone(&take);
        let work = move || {
            let mine = take.lock().unwrap_or_else(PoisonError::into_inner).recv();
            if let Ok(mine) = mine {
                mine.run();
            }
        };
        Builder::new().name("worker".to_owned()).spawn(work).is_ok()
    });
    let pool = ThreadPoolBuilder::new();
    // It fails only if there is a pool already, which will do as well.
    let _ = match made.count() {
        0 => pool.num_threads(1).use_current_thread().build_global(),
        made => {
            let hand = move |thread| give.send(thread).map_err(|_| std::io::ErrorKind::BrokenPipe.into());
            pool.num_threads(made).spawn_handler(hand).build_global()
        }
    };
}
