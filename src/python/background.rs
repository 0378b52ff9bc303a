//! Runs long work on a second thread, while the calling thread handles Python signals.
//!
//! Python runs its signal handlers only when the calling thread asks for them. A dense decomposition cannot be
//! interrupted, and it takes minutes for a few thousand degrees of freedom. Therefore the calling thread waits for the
//! work and checks for signals every 50 ms. In a worker of a sweep, which receives no signals, it also asks whether the
//! sweep must stop. When Python raises an exception (Ctrl-C), work that reports progress stops
//! at its next report and returns a partial result. Other work stops at its next [`Interrupt::check`]. If that takes
//! longer than [`GRACE`], the work is abandoned: the call returns, and the thread uses one processor and its memory
//! until its next check.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use super::errors;
use crate::analysis::{Interrupt, STACK};

/// Time between two checks for signals.
const HEARTBEAT: Duration = Duration::from_millis(50);
/// Time after which work that does not stop is abandoned.
const GRACE: Duration = Duration::from_millis(200);

enum Message<T> {
    /// The completed fraction. The thread then waits for the answer whether to continue.
    Progress(f64),
    Done(T),
}

/// Runs `work` and returns its result and the exception that Python raised in the meantime.
///
/// `work` calls its second argument with the completed fraction. That function passes the fraction to `progress` and
/// returns whether to continue.
///
/// # Errors
/// The exception that Python raised, if the analysis was abandoned. A `GearbowError`, if `work` panics. An `OSError`, if no thread can be started.
/// `KeyboardInterrupt` in a worker of a sweep that must stop.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Interrupt, &mut dyn FnMut(f64) -> bool) -> T + Send + 'static,
) -> PyResult<(T, Option<PyErr>)> {
    // A sequence of short analyses stops as well.
    check_stop(py)?;
    let interrupt = Interrupt::default();
    let (send, messages) = mpsc::channel();
    let (answer, answers) = mpsc::channel();
    let checked = interrupt.clone();
    let body = move || {
        let mut report = |done| send.send(Message::Progress(done)).is_ok() && answers.recv().unwrap_or(false);
        let result = work(&checked, &mut report);
        // Nobody receives the result of abandoned work.
        send.send(Message::Done(result)).unwrap_or_default();
    };
    let thread = thread::Builder::new().name("gearbow".to_owned()).stack_size(STACK).spawn(body)?;
    py.detach(move || {
        let (mut raised, mut reports_progress) = (None, false);
        // Last time at which Python had not raised an exception.
        let mut last_quiet = Instant::now();
        loop {
            match messages.recv_timeout(HEARTBEAT) {
                Ok(Message::Done(result)) => {
                    // The thread ends as soon as it has released its memory.
                    thread.join().unwrap_or_default();
                    return Ok((result, raised));
                }
                Ok(Message::Progress(done)) => {
                    reports_progress = true;
                    raised = raised.or_else(|| poll_python(progress, Some(done)).err());
                    // The thread waits for this answer.
                    answer.send(raised.is_none()).unwrap_or_default();
                }
                Err(RecvTimeoutError::Timeout) => raised = raised.or_else(|| poll_python(progress, None).err()),
                Err(RecvTimeoutError::Disconnected) => match thread.join() {
                    Err(_) => return Err(errors::internal()),
                    Ok(()) => {
                        return Err(pyo3::exceptions::PyRuntimeError::new_err(
                            "the background thread returned no result",
                        ));
                    }
                },
            }
            if raised.is_none() {
                last_quiet = Instant::now();
                continue;
            }
            interrupt.request();
            // Work that reports progress stops at its next report, which follows soon: a step is short.
            if !reports_progress
                && last_quiet.elapsed() >= GRACE
                && let Some(raised) = raised.take()
            {
                return Err(raised);
            }
        }
    })
}

/// Runs an analysis without progress and returns its result.
///
/// # Errors
/// As [`run`], and the error of the analysis.
pub fn result_of<T, E>(py: Python<'_>, work: impl FnOnce(&Interrupt) -> Result<T, E> + Send + 'static) -> PyResult<T>
where
    T: Send + 'static,
    E: Send + 'static,
    PyErr: From<E>,
{
    reported_result(py, None, move |interrupt, _| work(interrupt))
}

/// Runs an analysis that reports the completed fraction to `progress`, as [`run`], and returns its result.
///
/// # Errors
/// As [`result_of`].
pub fn reported_result<T, E>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Interrupt, &mut dyn FnMut(f64) -> bool) -> Result<T, E> + Send + 'static,
) -> PyResult<T>
where
    T: Send + 'static,
    E: Send + 'static,
    PyErr: From<E>,
{
    let (result, raised) = run(py, progress, work)?;
    raised.map_or(Ok(()), Err)?;
    Ok(result?)
}

/// Raises `KeyboardInterrupt` in a worker of a sweep that must stop.
fn check_stop(py: Python<'_>) -> PyResult<()> {
    py.import("gearbow._parallel")?.getattr("check_stop")?.call0().map(|_| ())
}

/// Lets Python handle signals, asks whether the sweep of this thread must stop, and calls `progress` with the completed fraction.
fn poll_python(progress: Option<&Py<PyAny>>, done: Option<f64>) -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        check_stop(py)?;
        if let (Some(progress), Some(done)) = (progress, done) {
            progress.call1(py, (done,))?;
        }
        Ok(())
    })
}

/// Panics as an analysis with a fault would, for the test that users then see a `GearbowError`.
#[pyfunction]
pub fn panic_in_analysis(py: Python<'_>, message: String) -> PyResult<()> {
    result_of(py, move |_| -> PyResult<()> { panic!("{message}") })
}
