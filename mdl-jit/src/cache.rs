//! Compiled functions, kept by what they do, and made better in the background.
//!
//! [`KernelCache::get`] compiles a function at the fast tier and returns at once; a worker compiles it
//! again, optimised, and swaps the code. A function with the same text, signature and options as an
//! earlier one, from whatever module, is that one: so code is shared by materials that differ in their
//! arguments only, and an edited argument compiles nothing. A fault names the place in the text of the
//! one that was compiled.

use std::collections::HashMap;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use naga::Handle;

use crate::batch::{Batch, Signature};
use crate::cranelift::Kernel;
use crate::emit::{EmitTarget, emit};
use crate::error::{CompileError, Fault};
use crate::executor::Program;
use crate::options::{Options, Tier};

/// What makes two functions the same.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    text: Vec<u8>,
    function: Option<String>,
    signature: Signature,
    options: Options,
}

/// A function whose code gets better.
#[derive(Debug)]
pub struct TieredKernel {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    kernel: Kernel,
    settled: bool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What the locks guard is whole at all times, so a panic elsewhere does not spoil it.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl TieredKernel {
    /// The best code there is now. It stays usable when better code comes.
    pub fn kernel(&self) -> Kernel {
        lock(&self.state).kernel.clone()
    }

    /// Whether no better code will come.
    pub fn is_settled(&self) -> bool {
        lock(&self.state).settled
    }

    /// Waits for the best code.
    pub fn settled(&self) -> Kernel {
        let guard = lock(&self.state);
        let done = self.changed.wait_while(guard, |s| !s.settled);
        done.unwrap_or_else(PoisonError::into_inner).kernel.clone()
    }

    /// Runs the best code there is now on `batch`.
    pub fn run(&self, batch: &mut Batch<'_>) -> Result<(), Fault> {
        self.kernel().run(batch)
    }

    /// Takes better code, or the news that there is none.
    fn settle(&self, better: Option<Kernel>) {
        let mut state = lock(&self.state);
        if let Some(kernel) = better {
            state.kernel = kernel;
        }
        state.settled = true;
        self.changed.notify_all();
    }
}

/// Something to be compiled again.
struct Job {
    program: Arc<Program>,
    function: Handle<naga::Function>,
    signature: Signature,
    options: Options,
    target: Arc<TieredKernel>,
}

/// Compiled functions by what they do.
#[derive(Debug)]
pub struct KernelCache {
    kernels: Mutex<HashMap<Key, Arc<TieredKernel>>>,
    worker: Option<Sender<Job>>,
}

impl Default for KernelCache {
    fn default() -> Self {
        Self::new()
    }
}

impl KernelCache {
    /// An empty cache with a worker thread, which ends with it. Without a thread to be had, the cache
    /// compiles optimised code at once.
    pub fn new() -> Self {
        let (sender, jobs) = channel::<Job>();
        let work = move || {
            for job in jobs {
                let Program { module, info } = &*job.program;
                let better = Kernel::compile(module, info, job.function, &job.signature, &job.options);
                job.target.settle(better.ok());
            }
        };
        let thread = std::thread::Builder::new().name("lacquer-compile".into()).spawn(work);
        Self { kernels: Mutex::default(), worker: thread.is_ok().then_some(sender) }
    }

    /// `function`, compiled for batches that fit `signature`.
    pub fn get(
        &self,
        program: &Arc<Program>,
        function: Handle<naga::Function>,
        signature: &Signature,
        options: &Options,
    ) -> Result<Arc<TieredKernel>, CompileError> {
        let text = emit(program, function, signature, options, EmitTarget::Wgsl)?;
        let name = program.module.functions[function].name.clone();
        let (signature, options) = (signature.clone(), options.clone());
        let key = Key { text, function: name, signature, options };
        if let Some(found) = lock(&self.kernels).get(&key) {
            return Ok(found.clone());
        }
        let compile = |tier| {
            let options = Options { tier, ..key.options.clone() };
            Kernel::compile(&program.module, &program.info, function, &key.signature, &options)
        };
        let later = self.worker.as_ref().filter(|_| key.options.tier == Tier::Optimised);
        let kernel = compile(if later.is_some() { Tier::Fast } else { key.options.tier })?;
        let state = State { kernel, settled: later.is_none() };
        let tiered = Arc::new(TieredKernel { state: Mutex::new(state), changed: Condvar::new() });
        if let Some(worker) = later {
            let (signature, options) = (key.signature.clone(), key.options.clone());
            let job = Job { program: program.clone(), function, signature, options, target: tiered.clone() };
            if worker.send(job).is_err() {
                tiered.settle(compile(Tier::Optimised).ok());
            }
        }
        // Two threads may have compiled the same; the first one's code is kept.
        Ok(lock(&self.kernels).entry(key).or_insert(tiered).clone())
    }

    /// Number of different functions.
    pub fn len(&self) -> usize {
        lock(&self.kernels).len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Argument, Input, Output};

    fn run(kernel: &TieredKernel) -> [f32; 3] {
        let mut out = [0.0; 3];
        let mut batch = Batch {
            len: 3,
            args: vec![Argument::Leaves(vec![Input::F32s(&[1.0, 2.0, 3.0])])],
            outputs: vec![Output::F32(&mut out)],
            ..Batch::default()
        };
        kernel.run(&mut batch).expect("the kernel runs");
        out
    }

    #[test]
    fn equal_functions_share_code_that_settles() {
        let cache = KernelCache::new();
        let get = |text: &str, options: &Options| {
            let program = Arc::new(Program::from_wgsl(text).expect("the program validates"));
            let f = program.function("f").expect("the function is there");
            let signature = Signature::varying(&program.module, f);
            cache.get(&program, f, &signature, options).expect("it compiles")
        };
        let options = Options::default();
        let a = get("fn f(x: f32) -> f32 { return x * 2.0; } fn other() {}", &options);
        let b = get("fn unused() -> u32 { return 1u; } fn f(x: f32) -> f32 { return x * 2.0; }", &options);
        let c = get("fn f(x: f32) -> f32 { return x * 3.0; }", &options);
        let d =
            get("fn f(x: f32) -> f32 { return x * 2.0; }", &Options { tier: Tier::Plain, ..options.clone() });
        assert!(Arc::ptr_eq(&a, &b));
        assert!(!Arc::ptr_eq(&a, &c) && !Arc::ptr_eq(&a, &d));
        assert_eq!(cache.len(), 3);
        assert!(d.is_settled());
        assert_eq!((run(&a), run(&c)), ([2.0, 4.0, 6.0], [3.0, 6.0, 9.0]));
        a.settled();
        c.settled();
        assert!(a.is_settled() && c.is_settled());
        assert_eq!((run(&a), run(&c), run(&d)), ([2.0, 4.0, 6.0], [3.0, 6.0, 9.0], [2.0, 4.0, 6.0]));
        drop(cache);
        assert_eq!(run(&a), [2.0, 4.0, 6.0]);
    }
}
