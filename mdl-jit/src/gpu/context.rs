//! The device.

use std::sync::Arc;
use std::sync::Mutex;
use std::time::Duration;

use crate::error::CompileError;

/// A GPU, or a software driver for one, opened for compute. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Context {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    timeout: Duration,
    /// What the device complained of outside any error scope, and its loss.
    complaints: Arc<Mutex<Vec<String>>>,
}

/// How long one dispatch may take, unless [`Context::with_timeout`] says otherwise.
const TIMEOUT: Duration = Duration::from_secs(120);

impl Context {
    /// Opens the most powerful adapter. The error says if there is none.
    pub fn new() -> Result<Self, CompileError> {
        Self::with_timeout(TIMEOUT)
    }

    /// The same, with another limit on the time of one dispatch.
    pub fn with_timeout(timeout: Duration) -> Result<Self, CompileError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::VULKAN;
        let instance = wgpu::Instance::new(descriptor);
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        }))
        .map_err(|e| CompileError::Gpu(format!("no adapter: {e}")))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("lacquer"),
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .map_err(|e| CompileError::Gpu(format!("no device: {e}")))?;
        let complaints = Arc::new(Mutex::new(Vec::new()));
        let note = |list: &Arc<Mutex<Vec<String>>>| {
            let list = list.clone();
            move |text: String| {
                if let Ok(mut list) = list.lock() {
                    list.push(text);
                }
            }
        };
        let (uncaptured, lost) = (note(&complaints), note(&complaints));
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| uncaptured(e.to_string())));
        device.set_device_lost_callback(move |_, text| lost(format!("the device was lost: {text}")));
        let info = adapter.get_info();
        Ok(Self { inner: Arc::new(Inner { device, queue, info, timeout, complaints }) })
    }

    /// Name of the adapter and its driver.
    pub fn name(&self) -> String {
        let info = &self.inner.info;
        format!("{} ({:?}, {} {})", info.name, info.device_type, info.driver, info.driver_info)
    }

    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        &self.inner.device
    }

    /// The queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.inner.queue
    }

    /// Runs `f` and returns the first error that the device reports meanwhile.
    pub(super) fn checked<T>(&self, f: impl FnOnce() -> T) -> Result<T, String> {
        let device = self.device();
        let scopes =
            [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal]
                .map(|filter| device.push_error_scope(filter));
        let value = f();
        let mut first = None;
        for scope in scopes.into_iter().rev() {
            if let Some(e) = pollster::block_on(scope.pop()) {
                first = Some(e.to_string());
            }
        }
        let complaint = self.inner.complaints.lock().ok().and_then(|mut list| list.pop());
        match first.or(complaint) {
            None => Ok(value),
            Some(e) => Err(e),
        }
    }

    /// Waits for everything submitted.
    pub(super) fn wait(&self) -> Result<(), String> {
        let poll = wgpu::PollType::Wait { submission_index: None, timeout: Some(self.inner.timeout) };
        self.device().poll(poll).map(drop).map_err(|e| e.to_string())
    }
}
