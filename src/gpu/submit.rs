//! Handing a recording to the queue, and waiting for it.

use std::sync::{Arc, MutexGuard};
use std::time::Duration;

use ash::vk;

use super::buffer::Host;
use super::encode::Encoder;
use super::track::Tracker;
use super::{Command, Device, GpuError, Recording};

/// Work on its way. Holds all it uses; dropping it waits for its end.
pub struct Submission {
    device: Arc<Device>,
    pool: vk::CommandPool,
    times: Option<vk::QueryPool>,
    passes: u32,
    value: u64,
    /// Everything that the commands use.
    held: Tracker,
}

impl Device {
    /// Starts the work of `recording` after all that was submitted before.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for a command that contradicts its objects, [`GpuError::DeviceLost`], or what Vulkan says.
    /// Nothing has then been started.
    pub fn submit(self: &Arc<Self>, recording: &Recording) -> Result<Submission, GpuError> {
        let mut queue = self.queue();
        let mut submission = Submission::new(self, recording)?;
        let commands = submission.record(recording)?;
        let value = queue.submitted + 1;
        let buffers: Vec<_> = submission.held.used_buffers().cloned().collect();
        // Locked while the work is handed over, so that the host is never writing at that moment.
        let mut hosts: Vec<MutexGuard<Host>> = buffers.iter().map(|buffer| buffer.host()).collect();
        self.hand_over(queue.raw, commands, value)?;
        hosts.iter_mut().for_each(|host| host.last_use = value);
        submission.held.commit();
        (queue.submitted, submission.value) = (value, value);
        Ok(submission)
    }

    fn hand_over(&self, queue: vk::Queue, commands: vk::CommandBuffer, value: u64) -> Result<(), GpuError> {
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let done = vk::SemaphoreSubmitInfo::default()
            .semaphore(self.timeline())
            .value(value);
        let done = [done.stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)];
        let info = vk::SubmitInfo2::default()
            .command_buffer_infos(&commands)
            .signal_semaphore_infos(&done);
        // SAFETY: the queue is locked by the caller, the command buffer ended, and the value above all before it.
        unsafe { self.raw().queue_submit2(queue, &[info], vk::Fence::null()) }.map_err(GpuError::vulkan("submit"))
    }
}

impl Submission {
    fn new(device: &Arc<Device>, recording: &Recording) -> Result<Self, GpuError> {
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(device.family());
        // SAFETY: the family is the device's.
        let pool = unsafe { device.raw().create_command_pool(&info, None) };
        let pool = pool.map_err(GpuError::vulkan("create a command pool"))?;
        let passes = recording
            .commands
            .iter()
            .filter(|command| matches!(command, Command::Render(_)))
            .count();
        let passes = u32::try_from(passes).unwrap_or(u32::MAX);
        let device = Arc::clone(device);
        let mut submission = Self {
            device,
            pool,
            times: None,
            passes,
            value: 0,
            held: Tracker::default(),
        };
        submission.times = submission.query_pool()?;
        Ok(submission)
    }

    fn query_pool(&self) -> Result<Option<vk::QueryPool>, GpuError> {
        if self.passes == 0 || self.device.info().limits.timestamp_period_ns == 0.0 {
            return Ok(None);
        }
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP);
        let info = info.query_count(self.passes.saturating_mul(2));
        // SAFETY: the device can time its work.
        let pool = unsafe { self.device.raw().create_query_pool(&info, None) };
        pool.map(Some).map_err(GpuError::vulkan("create a query pool"))
    }

    fn record(&mut self, recording: &Recording) -> Result<vk::CommandBuffer, GpuError> {
        let raw = self.device.raw();
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.pool)
            .command_buffer_count(1);
        // SAFETY: the pool is this submission's own.
        let buffers = unsafe { raw.allocate_command_buffers(&info) }.map_err(GpuError::vulkan("record"))?;
        let commands = buffers.first().copied().unwrap_or_default();
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is new; the queries are this submission's own.
        unsafe {
            raw.begin_command_buffer(commands, &once)
                .map_err(GpuError::vulkan("record"))?;
            if let Some(times) = self.times {
                raw.cmd_reset_query_pool(commands, times, 0, 2 * self.passes);
            }
        }
        Encoder::new(&self.device, commands, self.times).encode(recording, &mut self.held)?;
        // SAFETY: the command buffer is being recorded.
        unsafe { self.device.raw().end_command_buffer(commands) }.map_err(GpuError::vulkan("record"))?;
        Ok(commands)
    }

    /// Waits for the end of the work.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`], or what Vulkan says.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device.wait_for(self.value, Duration::MAX).map(drop)
    }

    /// Waits, but no longer than `timeout`; has the work ended?
    ///
    /// # Errors
    /// As [`Submission::wait`].
    pub fn wait_timeout(&self, timeout: Duration) -> Result<bool, GpuError> {
        self.device.wait_for(self.value, timeout)
    }

    /// Waits, and returns how long the device took for each render pass; empty if it cannot say.
    ///
    /// # Errors
    /// As [`Submission::wait`].
    pub fn pass_times(&self) -> Result<Vec<Duration>, GpuError> {
        self.wait()?;
        let Some(pool) = self.times else {
            return Ok(Vec::new());
        };
        let mut ticks = vec![0u64; 2 * self.passes as usize];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the pool has as many queries, all written by the work that has ended.
        let got = unsafe { self.device.raw().get_query_pool_results(pool, 0, &mut ticks, flags) };
        got.map_err(GpuError::vulkan("read timestamps"))?;
        let period_ns = f64::from(self.device.info().limits.timestamp_period_ns);
        let time = |pair: &[u64]| Duration::from_nanos((pair[1].saturating_sub(pair[0]) as f64 * period_ns) as u64);
        Ok(ticks.chunks_exact(2).map(time).collect())
    }
}

impl Drop for Submission {
    fn drop(&mut self) {
        // A lost device runs nothing any more, so an error here leaves nothing in use.
        let _ = self.wait();
        // SAFETY: the work has ended, or was never started; both are destroyed once.
        unsafe {
            if let Some(times) = self.times {
                self.device.raw().destroy_query_pool(times, None);
            }
            self.device.raw().destroy_command_pool(self.pool, None);
        }
    }
}
