//! Work that takes long, on a thread of its own, while this one looks whether somebody has pressed Ctrl-C.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Duration;
use twinrotor_tune::parallel::Stop;

/// How often Python is asked whether somebody has pressed Ctrl-C.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Does `work` on a thread of its own: this one, where Python's signals arrive, waits for it. After Ctrl-C
/// the work is asked to stop, and whatever comes of it, the interrupt is raised.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(Stop<'_>) -> PyResult<T> + Send,
) -> PyResult<T> {
    let stopped = AtomicBool::new(false);
    py.detach(|| {
        std::thread::scope(|scope| {
            let (ended, end) = mpsc::channel();
            let stopped = &stopped;
            scope.spawn(move || {
                let outcome = work(&|| stopped.load(Ordering::Relaxed));
                // Whoever waited is gone only if this thread is.
                let _ = ended.send(outcome);
            });
            let mut interrupted = Ok(());
            loop {
                match end.recv_timeout(LOOK_EVERY) {
                    Ok(outcome) => return interrupted.and(outcome),
                    Err(mpsc::RecvTimeoutError::Timeout) => {
                        if let Err(error) = Python::attach(|py| py.check_signals()) {
                            stopped.store(true, Ordering::Relaxed);
                            interrupted = Err(error);
                        }
                    }
                    Err(mpsc::RecvTimeoutError::Disconnected) => {
                        return Err(PyRuntimeError::new_err("the work ended without an outcome"));
                    }
                }
            }
        })
    })
}
