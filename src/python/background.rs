//! Long work on a thread of its own, while the calling thread listens to Python.
//!
//! Python runs its signal handlers only when the calling thread asks for them. A dense decomposition cannot be asked
//! anything until it ends, which takes minutes for a few thousand degrees of freedom. So the calling thread waits for
//! the work and asks Python every 50 ms. When Python raises (Ctrl-C), work that reports progress stops at its next
//! report and hands over what it has. Other work stops at its next [`Interrupt::check`]. If that takes longer than
//! [`GRACE`], the work is abandoned: the call returns, and the thread keeps one processor and its matrices until its
//! next check.

use std::panic::resume_unwind;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use crate::analysis::Interrupt;

/// Time between two questions to Python.
const HEARTBEAT: Duration = Duration::from_millis(50);
/// Time that work gets to stop before it is abandoned.
const GRACE: Duration = Duration::from_millis(200);
/// Stack of the thread, bytes: what the main thread of a process usually has.
const STACK: usize = 8 << 20;

enum Message<T> {
    /// The fraction that is done; the thread waits for an answer whether to go on.
    Progress(f64),
    Done(T),
}

/// Runs `work` and gives its result, with the exception that Python raised meanwhile. The second argument of `work`
/// takes the fraction that is done, which `progress` is called with, and says whether to go on.
///
/// # Errors
/// What Python raised, if the work was abandoned; the system's error if it starts no thread.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Interrupt, &mut dyn FnMut(f64) -> bool) -> T + Send + 'static,
) -> PyResult<(T, Option<PyErr>)> {
    let interrupt = Interrupt::default();
    let (send, messages) = mpsc::channel();
    let (answer, answers) = mpsc::channel();
    let checked = interrupt.clone();
    let body = move || {
        let mut report = |done| send.send(Message::Progress(done)).is_ok() && answers.recv().unwrap_or(false);
        let result = work(&checked, &mut report);
        // Nobody listens to abandoned work.
        send.send(Message::Done(result)).unwrap_or_default();
    };
    let thread = thread::Builder::new().name("gearbow".to_owned()).stack_size(STACK).spawn(body)?;
    py.detach(move || {
        let (mut raised, mut reported) = (None, false);
        // When Python had not raised yet.
        let mut quiet = Instant::now();
        loop {
            match messages.recv_timeout(HEARTBEAT) {
                Ok(Message::Done(result)) => {
                    // It only has to drop what it holds.
                    thread.join().unwrap_or_default();
                    return Ok((result, raised));
                }
                Ok(Message::Progress(done)) => {
                    reported = true;
                    raised = raised.or_else(|| ask(progress, Some(done)).err());
                    // The thread is there: it waits for this answer.
                    answer.send(raised.is_none()).unwrap_or_default();
                }
                Err(RecvTimeoutError::Timeout) => raised = raised.or_else(|| ask(progress, None).err()),
                Err(RecvTimeoutError::Disconnected) => match thread.join() {
                    Err(panic) => resume_unwind(panic),
                    Ok(()) => return Err(pyo3::exceptions::PyRuntimeError::new_err("the work gave no result")),
                },
            }
            if raised.is_none() {
                quiet = Instant::now();
                continue;
            }
            interrupt.request();
            // Work that reports stops at its next report: a step is short.
            if !reported
                && quiet.elapsed() >= GRACE
                && let Some(raised) = raised.take()
            {
                return Err(raised);
            }
        }
    })
}

/// Lets Python handle signals, and tells it the fraction that is done.
fn ask(progress: Option<&Py<PyAny>>, done: Option<f64>) -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        if let (Some(progress), Some(done)) = (progress, done) {
            progress.call1(py, (done,))?;
        }
        Ok(())
    })
}
