//! Shares of the environments, each with a thread. A share is handed to its thread to be worked on and is
//! handed back: nothing is shared, and nothing is allocated for it.

use super::share::{Job, Share};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

/// A thread that works on what it is handed.
struct Worker {
    todo: SyncSender<(Job, Box<Share>)>,
    done: Receiver<Box<Share>>,
}

impl Worker {
    fn new() -> std::io::Result<Self> {
        let (todo, jobs) = sync_channel::<(Job, Box<Share>)>(1);
        let (results, done) = sync_channel(1);
        // It ends when its batch is gone.
        thread::Builder::new().name("twinrotor-batch".to_owned()).spawn(move || {
            while let Ok((job, mut share)) = jobs.recv() {
                share.work(job);
                if results.send(share).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self { todo, done })
    }
}

/// All shares, in the order of the environments. The first one is worked on by whoever asks.
pub(super) struct Crew {
    shares: Vec<Option<Box<Share>>>,
    workers: Vec<Worker>,
}

impl Crew {
    /// A thread for each share but the first.
    pub(super) fn new(shares: Vec<Share>) -> std::io::Result<Self> {
        let workers = shares.iter().skip(1).map(|_| Worker::new()).collect::<Result<_, _>>()?;
        Ok(Self { shares: shares.into_iter().map(|share| Some(Box::new(share))).collect(), workers })
    }

    /// Does `job` on all; false if a thread is gone, with its share.
    pub(super) fn work(&mut self, job: Job) -> bool {
        let Some((own, others)) = self.shares.split_first_mut() else { return false };
        for (share, worker) in others.iter_mut().zip(&self.workers) {
            let Some(share) = share.take() else { return false };
            if worker.todo.send((job, share)).is_err() {
                return false;
            }
        }
        let Some(own) = own else { return false };
        own.work(job);
        for (share, worker) in others.iter_mut().zip(&self.workers) {
            *share = worker.done.recv().ok();
        }
        others.iter().all(Option::is_some)
    }

    pub(super) fn shares(&self) -> impl Iterator<Item = &Share> {
        self.shares.iter().flatten().map(AsRef::as_ref)
    }

    pub(super) fn shares_mut(&mut self) -> impl Iterator<Item = &mut Share> {
        self.shares.iter_mut().flatten().map(AsMut::as_mut)
    }
}
