//! A firmware's ELF: what to load, its symbols, and where its functions return.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use rigless::image::Image;
use twinrotor::board::{self, Board};

/// A firmware image with its symbols.
#[derive(Debug, Clone)]
pub struct Firmware {
    image: Image,
    /// The file.
    bytes: Arc<[u8]>,
    /// Functions by address: name and size.
    functions: BTreeMap<u64, (String, u64)>,
    /// Everything by its demangled or linker name: address and size.
    symbols: BTreeMap<String, (u64, u64)>,
    /// Executable bytes by address.
    code: BTreeMap<u64, Vec<u8>>,
    /// What it loads, a section each.
    loaded: Vec<Vec<u8>>,
    /// \[bytes\] that the flash and the RAM take.
    flash_size: u64,
    ram_size: u64,
    compiler: String,
}

/// Why a firmware could not be read.
#[derive(Debug)]
pub enum Error {
    /// The file is not there, or not readable.
    File(PathBuf, std::io::Error),
    /// The file is not an ELF image of a firmware.
    Elf(PathBuf, String),
}

impl fmt::Display for Error {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path, why) => {
                write!(to, "{}: {why}; build it with 'cargo fw', or set TWINROTOR_ELF", path.display())
            }
            Self::Elf(path, why) => write!(to, "{}: not a firmware ELF: {why}", path.display()),
        }
    }
}

impl std::error::Error for Error {}

/// Where a build under this folder of `target` puts the ELF.
fn built(folder: &str) -> PathBuf {
    let target = concat!(env!("CARGO_MANIFEST_DIR"), "/../../target");
    PathBuf::from(format!("{target}/{folder}thumbv7em-none-eabihf/firmware/firmware"))
}

/// Where RAM begins.
const RAM: u64 = 0x2000_0000;

impl Firmware {
    /// Whether both are of the same file.
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.bytes == other.bytes
    }

    /// Reads the ELF at `path`.
    ///
    /// # Errors
    ///
    /// If there is no such file, or it is not a firmware's ELF.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = std::fs::read(path).map_err(|why| Error::File(path.to_owned(), why))?;
        Self::new(path, bytes)
    }

    /// The released image: where the variable `TWINROTOR_ELF` says, else where `cargo fw` puts it.
    ///
    /// # Errors
    ///
    /// As [`Firmware::read`].
    pub fn released() -> Result<Self, Error> {
        let named = std::env::var_os("TWINROTOR_ELF").map(PathBuf::from);
        Self::read(&named.unwrap_or_else(|| built("")))
    }

    /// The released image for a board: where `cargo fw-BOARD` puts it.
    ///
    /// # Errors
    ///
    /// As [`Firmware::read`].
    pub fn released_for(board: Board) -> Result<Self, Error> {
        Self::read(&built(&format!("{}/", board.name)))
    }

    /// The released image with the feature `sign-magnitude`: where
    /// `cargo fw --features sign-magnitude --target-dir target/sign-magnitude` puts it.
    ///
    /// # Errors
    ///
    /// As [`Firmware::read`].
    pub fn sign_magnitude() -> Result<Self, Error> {
        Self::read(&built("sign-magnitude/"))
    }

    /// The released image with the feature `bootstrap`: where
    /// `cargo fw --features bootstrap --target-dir target/bootstrap` puts it.
    ///
    /// # Errors
    ///
    /// As [`Firmware::read`].
    pub fn bootstrap() -> Result<Self, Error> {
        Self::read(&built("bootstrap/"))
    }

    /// The released image with the feature `debug`: where
    /// `cargo fw --features debug --target-dir target/debug-build` puts it.
    ///
    /// # Errors
    ///
    /// As [`Firmware::read`].
    pub fn for_a_debugger() -> Result<Self, Error> {
        Self::read(&built("debug-build/"))
    }

    /// The released image that computes its rig itself: where `cargo fw-f405-sim` puts it.
    ///
    /// # Errors
    ///
    /// As [`Firmware::read`].
    pub fn simulated() -> Result<Self, Error> {
        Self::read(&built("f405-sim/"))
    }

    /// The same for another board: where `cargo fw-BOARD-sim` puts it.
    ///
    /// # Errors
    ///
    /// As [`Firmware::read`].
    pub fn simulated_on(board: Board) -> Result<Self, Error> {
        Self::read(&built(&format!("{}-sim/", board.name)))
    }

    /// The board for which it was built: what it loads has the name of the chip that it tells to its host,
    /// and its own, which it logs; the longer, where one is the end of the other.
    pub fn board(&self) -> Board {
        let has = |word: &str| {
            let word = word.as_bytes();
            self.loaded.iter().any(|section| section.windows(word.len()).any(|bytes| bytes == word))
        };
        let told = board::ALL.into_iter().filter(|board| has(board.chip) && has(board.name));
        told.max_by_key(|board| board.name.len()).unwrap_or_default()
    }

    fn new(path: &Path, bytes: Vec<u8>) -> Result<Self, Error> {
        let refuse = |why: String| Error::Elf(path.to_owned(), why);
        let elf = object::File::parse(&*bytes).map_err(|why| refuse(why.to_string()))?;
        let mut functions = BTreeMap::new();
        let mut symbols = BTreeMap::new();
        for symbol in elf.symbols() {
            let Ok(name) = symbol.name() else { continue };
            let name = plain_name(name);
            let function = symbol.kind() == SymbolKind::Text;
            let address = symbol.address() & !u64::from(function);
            if function && symbol.size() > 0 {
                functions.insert(address, (name.clone(), symbol.size()));
            }
            symbols.insert(name, (address, symbol.size()));
        }
        let (mut code, mut contents) = (BTreeMap::new(), Vec::new());
        let (mut flash_size, mut ram_size) = (0, 0);
        for section in elf.sections() {
            let object::SectionFlags::Elf { sh_flags, .. } = section.flags() else {
                continue;
            };
            if !sh_flags.contains(object::elf::SHF_ALLOC) {
                continue;
            }
            let loaded =
                section.kind() != object::SectionKind::UninitializedData && section.file_range().is_some();
            let in_ram = section.address() >= crate::chip::SRAM.0;
            if loaded {
                flash_size += section.size();
                contents.extend(section.data().map(<[u8]>::to_vec));
            }
            if in_ram {
                ram_size += section.size();
            }
            if sh_flags.contains(object::elf::SHF_EXECINSTR)
                && let Ok(data) = section.data()
            {
                code.insert(section.address(), data.to_vec());
            }
        }
        let compiler = elf.section_by_name(".comment").and_then(|section| section.data().ok().map(compiler));
        let compiler = compiler.unwrap_or_default();
        let image = Image::new(path, bytes.clone(), None).map_err(|why| refuse(why.to_string()))?;
        Ok(Self {
            image,
            bytes: bytes.into(),
            functions,
            symbols,
            code,
            loaded: contents,
            flash_size,
            ram_size,
            compiler,
        })
    }

    /// What the emulator loads.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// The file itself.
    pub fn bytes(&self) -> &Arc<[u8]> {
        &self.bytes
    }

    /// \[bytes\] of flash that the image takes.
    pub fn flash_size(&self) -> u64 {
        self.flash_size
    }

    /// \[bytes\] of RAM that its statics take, the stack aside.
    pub fn ram_size(&self) -> u64 {
        self.ram_size
    }

    /// The compiler that made it, such as `rustc 1.95.0`.
    pub fn compiler(&self) -> &str {
        &self.compiler
    }

    /// The address of a symbol.
    pub fn address(&self, name: &str) -> Option<u64> {
        self.symbols.get(name).map(|&(address, _)| address)
    }

    /// \[bytes\] Every symbol's name and size, and whether it lies in RAM.
    pub fn sizes(&self) -> impl Iterator<Item = (&str, u64, bool)> {
        self.symbols.iter().map(|(name, &(address, size))| (name.as_str(), size, address >= RAM))
    }

    /// Every symbol's name.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.symbols.keys().map(String::as_str)
    }

    /// The function that `address` lies in, and how far in.
    pub fn locate(&self, address: u64) -> String {
        match self.function_at(address) {
            Some((start, name, _)) => format!("{name}+{:#x}", address - start),
            None => format!("{address:#010x}"),
        }
    }

    /// The name of the function that `address` lies in, and where it begins.
    pub fn function(&self, address: u64) -> Option<(u64, &str)> {
        self.function_at(address).map(|(start, name, _)| (start, name))
    }

    /// The addresses of every instruction of function `name` and of all that it calls or ends in.
    pub fn closure(&self, name: &str) -> BTreeSet<u64> {
        let mut instructions = BTreeSet::new();
        let mut seen = BTreeSet::new();
        let mut waiting: Vec<u64> = self.address(name).into_iter().collect();
        while let Some(start) = waiting.pop() {
            if !seen.insert(start) {
                continue;
            }
            for (at, flow) in self.instructions(start) {
                instructions.insert(at);
                if let Flow::Jump(target) | Flow::Call(target) = flow
                    && let Some((callee, _, _)) = self.function_at(target)
                {
                    waiting.push(callee);
                }
            }
        }
        instructions
    }

    /// Where what `from` reaches by direct calls and branches goes on to a panic, `from` itself included, and
    /// to which.
    pub fn panics(&self, from: &str) -> Vec<(u64, &str)> {
        let mut places = Vec::new();
        let mut seen = BTreeSet::new();
        let mut waiting: Vec<u64> = self.address(from).into_iter().collect();
        while let Some(start) = waiting.pop() {
            if !seen.insert(start) {
                continue;
            }
            for (at, flow) in self.instructions(start) {
                if let Flow::Jump(target) | Flow::Call(target) = flow
                    && let Some((callee, name, _)) = self.function_at(target)
                {
                    if name.contains("panic") {
                        places.push((at, name));
                    } else {
                        waiting.push(callee);
                    }
                }
            }
        }
        places
    }

    /// The instructions of the function that begins at `start`, and what each does to the flow of control.
    /// Literals between them are taken for instructions as well, at addresses where the core never arrives.
    fn instructions(&self, start: u64) -> Vec<(u64, Flow)> {
        let end = self.function_at(start).map_or(start, |(start, _, size)| start + size);
        let (mut at, mut found) = (start, Vec::new());
        while at < end
            && let Some(first) = self.halfword(at)
        {
            let second = self.halfword(at + 2).unwrap_or(0);
            found.push((at, Flow::of(at, first, second)));
            at += if is_wide(first) { 4 } else { 2 };
        }
        found
    }

    fn function_at(&self, address: u64) -> Option<(u64, &str, u64)> {
        let (&start, (name, size)) = self.functions.range(..=address).next_back()?;
        (address < start + size).then_some((start, name, *size))
    }

    fn halfword(&self, address: u64) -> Option<u16> {
        let (start, bytes) = self.code.range(..=address).next_back()?;
        let at = usize::try_from(address - start).ok()?;
        let two = bytes.get(at..at + 2)?;
        Some(u16::from_le_bytes([two[0], two[1]]))
    }

    /// The addresses of the instructions by which function `name` returns to its caller, those of
    /// functions it ends by jumping into among them.
    pub fn returns(&self, name: &str) -> Vec<u64> {
        let mut returns = Vec::new();
        let mut seen = BTreeSet::new();
        let mut waiting: Vec<u64> = self.address(name).into_iter().collect();
        while let Some(start) = waiting.pop() {
            let Some((_, _, size)) = self.function_at(start).filter(|_| seen.insert(start)) else {
                continue;
            };
            for (at, flow) in self.instructions(start) {
                match flow {
                    Flow::Return => returns.push(at),
                    Flow::Jump(target) if !(start..start + size).contains(&target) => waiting.push(target),
                    Flow::Jump(_) | Flow::Call(_) | Flow::On => {}
                }
            }
        }
        returns
    }
}

/// The compiler's name and version in an ELF's comments.
fn compiler(comments: &[u8]) -> String {
    let text = String::from_utf8_lossy(comments);
    let line = text.split('\0').find(|line| line.starts_with("rustc"));
    line.map(|line| line.split_whitespace().take(3).collect::<Vec<_>>().join(" ")).unwrap_or_default()
}

/// A Rust symbol without its hash and its mangling, any other as it is.
fn plain_name(name: &str) -> String {
    let demangled = rustc_demangle::demangle(name);
    format!("{demangled:#}")
}

/// Whether a Thumb instruction that starts with `first` has 32 bits, DDI 0403E A5.1.
fn is_wide(first: u16) -> bool {
    first >> 11 >= 0b11101
}

/// What an instruction does to the flow of control, as far as leaving a function goes.
enum Flow {
    Return,
    Jump(u64),
    Call(u64),
    On,
}

impl Flow {
    /// DDI 0403E A7.7: BX LR, POP {.., PC}, LDM SP!, {.., PC}, LDR PC, [SP], #4, unconditional B, and BL.
    fn of(at: u64, first: u16, second: u16) -> Self {
        match (first, second) {
            (0x4770, _) => Self::Return,
            _ if first >> 8 == 0xBD => Self::Return,
            (0xE8BD, list) if list & 0x8000 != 0 => Self::Return,
            (0xF85D, 0xFB04) => Self::Return,
            _ if first >> 11 == 0b11100 => {
                let offset = i64::from((first << 5).cast_signed() >> 4);
                Self::Jump((at + 4).wrapping_add_signed(offset))
            }
            _ if first >> 11 == 0b11110 && second & 0x9000 == 0x9000 => {
                let bit = |value: u16, bit: u32| i64::from(value >> bit & 1);
                let sign = bit(first, 10);
                let i1 = 1 - (bit(second, 13) ^ sign);
                let i2 = 1 - (bit(second, 11) ^ sign);
                let offset = -sign << 24
                    | i1 << 23
                    | i2 << 22
                    | i64::from(first & 0x3FF) << 12
                    | i64::from(second & 0x7FF) << 1;
                let target = (at + 4).wrapping_add_signed(offset);
                if second & 0x4000 == 0 { Self::Jump(target) } else { Self::Call(target) }
            }
            _ => Self::On,
        }
    }
}
