//! NVIDIA's driver, found at run time, and the kernels that were there when this was built.

use super::driver::{Argument, Driver, Fault};
use crate::BLOCK;
use cudarc::driver::{
    CudaContext, CudaFunction, CudaModule, CudaSlice, CudaStream, DriverError, LaunchConfig, PushKernelArg,
    sys,
};
use cudarc::nvrtc::Ptx;
use std::format;
use std::string::{String, ToString};
use std::sync::Arc;
use std::vec::Vec;

/// The kernels' text, if `scripts/build-ptx.sh` had made it when this was built.
const KERNELS: Option<&str> = include!(concat!(env!("OUT_DIR"), "/kernels.rs"));

/// Threads that go side by side.
const WARP: u32 = 32;

/// The first card of this machine.
#[derive(Debug)]
pub struct Cuda {
    context: Arc<CudaContext>,
    stream: Arc<CudaStream>,
    module: Arc<CudaModule>,
}

impl From<DriverError> for Fault {
    fn from(error: DriverError) -> Self {
        if error.0 == sys::CUresult::CUDA_ERROR_OUT_OF_MEMORY {
            return Self::Memory;
        }
        let words = |text: Result<&std::ffi::CStr, _>| text.map(|t| t.to_string_lossy().into_owned());
        Self::Lost(words(error.error_string()).unwrap_or_else(|_| format!("{:?}", error.0)))
    }
}

fn none(why: &str) -> Fault {
    Fault::NoDevice(why.to_string())
}

impl Cuda {
    /// Looks for a driver and a card, and gives it the kernels.
    ///
    /// # Errors
    /// Which of these there is not.
    pub fn find() -> Result<Self, Fault> {
        let Some(kernels) = KERNELS else {
            return Err(none(
                "this program was built without kernels; run scripts/build-ptx.sh and build it again",
            ));
        };
        Self::with(kernels)
    }

    /// The same with other `kernels` than those that were there when this was built, as text.
    ///
    /// # Errors
    /// Which of driver and card there is not.
    pub fn with(kernels: &str) -> Result<Self, Fault> {
        // SAFETY: opens and closes the driver's library, as the next lines would.
        #[expect(unsafe_code, reason = "cudarc panics where there is no driver, and this asks first")]
        let present = unsafe { sys::is_culib_present() };
        if !present {
            return Err(none("NVIDIA's driver (libcuda) is not installed"));
        }
        let context = CudaContext::new(0).map_err(|error| match Fault::from(error) {
            Fault::Lost(why) | Fault::NoDevice(why) => Fault::NoDevice(why),
            Fault::Memory => Fault::Memory,
        })?;
        let (major, minor) = context.compute_capability()?;
        if (major, minor) < (7, 5) {
            let name = context.name()?;
            return Err(none(&format!(
                "{name} is of compute capability {major}.{minor}; allowed: 7.5 or newer"
            )));
        }
        let module = context.load_module(Ptx::from_src(kernels))?;
        Ok(Self { stream: context.default_stream(), context, module })
    }

    fn function(&self, kernel: &str) -> Result<CudaFunction, Fault> {
        Ok(self.module.load_function(kernel)?)
    }
}

/// What a kernel takes of a card, as its driver has translated it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Needs {
    /// Registers of a thread.
    pub registers: i32,
    /// \[bytes\] A thread's own memory, where what finds no register is.
    pub local: i32,
    /// \[bytes\] Of a block's.
    pub shared: i32,
    /// Warps that a multiprocessor has of it at a time.
    pub warps: u32,
}

impl Cuda {
    /// What a kernel takes.
    ///
    /// # Errors
    /// There is none of this name, or the card is lost.
    pub fn needs(&self, kernel: &str) -> Result<Needs, Fault> {
        let function = self.function(kernel)?;
        let blocks = function.occupancy_max_active_blocks_per_multiprocessor(BLOCK, 0, None)?;
        Ok(Needs {
            registers: function.num_regs()?,
            local: function.local_size_bytes()?,
            shared: function.shared_size_bytes()?,
            warps: blocks * (BLOCK / WARP),
        })
    }
}

impl Driver for Cuda {
    type Memory = CudaSlice<u32>;

    fn name(&self) -> String {
        self.context.name().unwrap_or_else(|_| "a CUDA device".to_string())
    }

    fn free(&self) -> Result<u64, Fault> {
        Ok(self.context.mem_get_info()?.0 as u64)
    }

    fn upload(&self, words: &[u32]) -> Result<Self::Memory, Fault> {
        Ok(self.stream.clone_htod(words)?)
    }

    fn reserve(&self, words: usize) -> Result<Self::Memory, Fault> {
        Ok(self.stream.alloc_zeros(words)?)
    }

    fn launch(
        &self,
        kernel: &str,
        arguments: &[Argument<'_, Self::Memory>],
        threads: u32,
    ) -> Result<(), Fault> {
        let function = self.function(kernel)?;
        let mut launch = self.stream.launch_builder(&function);
        for argument in arguments {
            match argument {
                Argument::Copied(words) => launch.arg(*words),
                Argument::Words(memory) => launch.arg(*memory),
                Argument::Number(number) => launch.arg(number),
            };
        }
        let shape = LaunchConfig {
            grid_dim: (threads.div_ceil(BLOCK), 1, 1),
            block_dim: (BLOCK, 1, 1),
            shared_mem_bytes: 0,
        };
        #[expect(unsafe_code, reason = "what a kernel is called with, no compiler checks")]
        // SAFETY: the arguments are those that `ptx.rs` declares, each length that of the memory before it
        // (`card.rs`); threads beyond the last flight do nothing.
        unsafe {
            launch.launch(shape)?
        };
        Ok(self.stream.synchronize()?)
    }

    fn download(&self, memory: &Self::Memory) -> Result<Vec<u32>, Fault> {
        Ok(self.stream.clone_dtoh(memory)?)
    }
}
