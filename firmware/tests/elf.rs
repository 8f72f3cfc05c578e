//! The built firmware, read as a file: what must not be in it, what it weighs, where it lies.
//!
//! `cargo fw`, then `cargo fw-test`, which fails where there is no file. A plain `cargo test` has no compiler
//! for the board; it lists these tests as not run. `TWINROTOR_ELF` names another file than the one in the
//! target folder.

use object::{Object, ObjectSection, ObjectSegment, ObjectSymbol, SectionKind, SymbolKind};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use twinrotor::parameters::ram_flash::AREA_SIZE;
use twinrotor::parameters::store::AREA_ADDRESS;

/// A function: where its code begins, and the code.
struct Function {
    name: String,
    address: u64,
    size: u64,
}

struct Firmware {
    bytes: Vec<u8>,
}

impl Firmware {
    fn read() -> Self {
        let path = std::env::var_os("TWINROTOR_ELF").map_or_else(built, PathBuf::from);
        let bytes = std::fs::read(&path)
            .unwrap_or_else(|error| panic!("{}: {error}; run `cargo fw` first", path.display()));
        Self { bytes }
    }

    /// The firmware whose rig is computed on the board: where `cargo fw-f405-sim` puts it.
    fn simulated() -> Self {
        let path = target().join("f405-sim").join(ELF);
        let bytes = std::fs::read(&path)
            .unwrap_or_else(|error| panic!("{}: {error}; run `cargo fw-f405-sim` first", path.display()));
        Self { bytes }
    }

    fn elf(&self) -> object::File<'_> {
        object::File::parse(&*self.bytes).expect("an ELF file")
    }

    fn symbols(&self) -> BTreeSet<String> {
        self.elf().symbols().filter_map(|symbol| symbol.name().ok().map(demangled)).collect()
    }

    /// Functions by address. The lowest bit of a symbol's says Thumb.
    fn functions(&self) -> BTreeMap<u64, Function> {
        let elf = self.elf();
        let functions = elf.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0);
        functions
            .map(|symbol| {
                let address = symbol.address() & !1;
                let name = demangled(symbol.name().expect("a name"));
                (address, Function { name, address, size: symbol.size() })
            })
            .collect()
    }

    /// Addresses at which data stands among the code: from `$d` to the next `$t`.
    fn data_in_code(&self) -> BTreeMap<u64, bool> {
        let elf = self.elf();
        let marks = elf.symbols().filter_map(|symbol| match symbol.name() {
            Ok(name) if name == "$d" || name.starts_with("$d.") => Some((symbol.address(), true)),
            Ok(name) if name == "$t" || name.starts_with("$t.") => Some((symbol.address(), false)),
            _ => None,
        });
        marks.collect()
    }

    fn half_word(&self, address: u64) -> u16 {
        let elf = self.elf();
        let section = elf
            .sections()
            .find(|s| {
                s.kind() == SectionKind::Text && (s.address()..s.address() + s.size()).contains(&address)
            })
            .expect("code");
        let offset = usize::try_from(address - section.address()).expect("a 64-bit host");
        let bytes = section.data().expect("readable");
        u16::from_le_bytes([bytes[offset], bytes[offset + 1]])
    }

    /// Names of all that `from` reaches by direct calls and branches, itself included.
    fn closure(&self, from: &str) -> BTreeSet<String> {
        let functions = self.functions();
        let data = self.data_in_code();
        let start: Vec<u64> = functions.values().filter(|f| f.name == from).map(|f| f.address).collect();
        assert_eq!(start.len(), 1, "exactly one function {from}");
        let (mut waiting, mut seen) = (start, BTreeSet::new());
        while let Some(address) = waiting.pop() {
            if seen.insert(address) {
                let function = &functions[&address];
                for target in self.branches(function, &data) {
                    if let Some((&callee, f)) = functions.range(..=target).next_back()
                        && target < f.address + f.size
                    {
                        waiting.push(callee);
                    }
                }
            }
        }
        seen.iter().map(|address| functions[address].name.clone()).collect()
    }

    /// Targets outside `function` of its BL, B.W and conditional B.W (ARMv7-M reference manual, A7.7.12 and
    /// A7.7.18).
    fn branches(&self, function: &Function, data: &BTreeMap<u64, bool>) -> Vec<u64> {
        let end = function.address + function.size;
        let (mut at, mut targets) = (function.address, vec![]);
        while at + 2 <= end {
            if data.range(..=at).next_back().is_some_and(|(_, is_data)| *is_data) {
                at += 2;
                continue;
            }
            let first = self.half_word(at);
            if first >> 11 < 0b11101 {
                at += 2;
                continue;
            }
            let second = self.half_word(at + 2);
            if let Some(offset) = branch_offset(first, second) {
                let target = (at + 4).wrapping_add_signed(offset.into());
                if !(function.address..end).contains(&target) {
                    targets.push(target);
                }
            }
            at += 4;
        }
        targets
    }
}

/// How far a 32-bit branch goes, if it is one.
fn branch_offset(first: u16, second: u16) -> Option<i32> {
    let bit = |word: u16, n: u32| i32::from(word >> n & 1);
    let bits = |word: u16, mask: u16| i32::from(word & mask);
    if first >> 11 != 0b11110 || second >> 15 != 1 {
        return None;
    }
    let sign = bit(first, 10);
    if bit(second, 12) == 1 {
        let (j1, j2) = (bit(second, 13), bit(second, 11));
        let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
        let low = bits(first, 0x3FF) << 12 | bits(second, 0x7FF) << 1;
        Some((-sign << 24) | i1 << 23 | i2 << 22 | low)
    } else if bit(second, 14) == 0 && first >> 6 & 0b1110 != 0b1110 {
        let low = bits(first, 0x3F) << 12 | bits(second, 0x7FF) << 1;
        Some((-sign << 20) | bit(second, 11) << 19 | bit(second, 13) << 18 | low)
    } else {
        None
    }
}

fn demangled(name: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(name))
}

/// Where a build puts it in its target folder.
const ELF: &str = "thumbv7em-none-eabihf/firmware/firmware";

/// The target folder that this test was built in.
fn target() -> PathBuf {
    let test = std::env::current_exe().expect("a test has a path");
    test.ancestors().nth(3).expect("target/debug/deps/test").to_owned()
}

/// Where `cargo fw` puts it.
fn built() -> PathBuf {
    target().join(ELF)
}

/// A routine of double precision.
fn is_soft_double(name: &str) -> bool {
    name.starts_with("__aeabi_d")
        || name.starts_with("__aeabi_f2d")
        || name.ends_with("2d")
        || name.ends_with("df3")
}

#[test]
fn branches_are_decoded_as_the_manual_says() {
    // From an assembler: bl .+4, bl .-4, b.w .+0x1000, beq.w .+0x100; then mrs and ldr.w, which are none.
    assert_eq!(branch_offset(0xF000, 0xF800), Some(0));
    assert_eq!(branch_offset(0xF7FF, 0xFFFC), Some(-8));
    assert_eq!(branch_offset(0xF000, 0xBFFE), Some(0xFFC));
    assert_eq!(branch_offset(0xF000, 0x807E), Some(0xFC));
    assert_eq!(branch_offset(0xF3EF, 0x8008), None);
    assert_eq!(branch_offset(0xF8D0, 0x1000), None);
}

#[test]
#[cfg_attr(not(feature = "elf-tests"), ignore = "reads the ELF: cargo fw, then cargo fw-test")]
fn no_soft_double_no_float_formatting_no_allocator() {
    let symbols = Firmware::read().symbols();
    assert!(symbols.len() > 100, "the unstripped file");
    let banned = |name: &str| {
        is_soft_double(name)
            || name.contains("flt2dec")
            || name.contains("fmt::float")
            || name.contains("__rust_alloc")
    };
    let found: Vec<&String> = symbols.iter().filter(|name| banned(name)).collect();
    assert!(found.is_empty(), "{found:?}");
}

/// A rig that the board computes is made in double precision, in the thread, and moved in single, in the
/// tick.
#[test]
#[cfg_attr(not(feature = "elf-tests"), ignore = "reads the ELF: cargo fw-f405-sim, then cargo fw-test")]
fn a_simulated_rig_has_no_soft_double_in_the_tick() {
    let firmware = Firmware::simulated();
    let tick = firmware.closure("TIM1_UP_TIM10");
    assert!(!tick.is_empty());
    let found: Vec<&String> = tick.iter().filter(|name| is_soft_double(name)).collect();
    assert!(found.is_empty(), "{found:?}");
    assert!(firmware.symbols().iter().any(|name| is_soft_double(name)), "it is made in double precision");
}

/// Each thing that the log tells, by its words, which defmt keeps as the names of symbols: none of them is on
/// the chip, and none is told from within the tick.
#[test]
#[cfg_attr(not(feature = "elf-tests"), ignore = "reads the ELF: cargo fw, then cargo fw-test")]
fn the_log_tells_what_the_board_does_and_its_words_stay_in_the_file() {
    let firmware = Firmware::read();
    let symbols = firmware.symbols();
    let elf = firmware.elf();
    let loadable: Vec<&[u8]> = elf.segments().map(|segment| segment.data().expect("readable")).collect();
    for words in [
        ": parameters ",
        "the last boot ended by",
        "tick {=u32}: ",
        "first-power check: ",
        "refused: ",
        "no message: ",
        "an old message, number",
        "parameters saved",
        "a tick took {=u32} cycles",
    ] {
        let told = |name: &&String| name.contains(r#""tag":"defmt_"#) && name.contains(words);
        assert!(symbols.iter().any(|name| told(&name)), "nobody says '{words}'");
        let on_chip = |bytes: &&[u8]| bytes.windows(words.len()).any(|window| window == words.as_bytes());
        assert!(!loadable.iter().any(on_chip), "'{words}' is in the flash");
    }
    let logs = |names: &BTreeSet<String>| names.iter().any(|name| name.contains("defmt"));
    assert!(!logs(&firmware.closure("TIM1_UP_TIM10")));
    // The thread, which has such functions, is where they are called.
    assert!(logs(&firmware.functions().into_values().map(|function| function.name).collect()));
}

#[test]
#[cfg_attr(not(feature = "elf-tests"), ignore = "reads the ELF: cargo fw, then cargo fw-test")]
fn it_lies_where_the_memory_map_says() {
    let firmware = Firmware::read();
    let elf = firmware.elf();
    let parameters = u64::from(AREA_ADDRESS)..u64::from(AREA_ADDRESS) + AREA_SIZE as u64;
    for section in
        elf.sections().filter(|s| s.size() > 0 && (0x0800_0000..0x0810_0000).contains(&s.address()))
    {
        let (begin, end) = (section.address(), section.address() + section.size());
        assert!(
            end <= parameters.start || begin >= parameters.end,
            "{:?} covers the parameters",
            section.name()
        );
    }
    for section in
        elf.sections().filter(|s| s.size() > 0 && (0x2000_0000..0x2002_0000).contains(&s.address()))
    {
        assert!(section.address() >= 0x2000_A000, "{:?} lies in the stack", section.name());
    }
    let vectors = elf.section_by_name(".vector_table").expect("a vector table");
    assert_eq!(vectors.address(), 0x0800_0000);
    assert_eq!(vectors.data().expect("readable")[..4], 0x2000_A000_u32.to_le_bytes());
}

/// \[byte\] Loadable, and static RAM.
fn sizes(firmware: &Firmware) -> (u64, u64) {
    let elf = firmware.elf();
    let loadable = elf.segments().map(|segment| segment.file_range().1).sum();
    let ram = elf.sections().filter(|s| (0x2000_0000..0x2002_0000).contains(&s.address()));
    (loadable, ram.map(|section| section.size()).sum())
}

/// `firmware/figures.csv` has a row for each compiler; a change of more than 2 % wants a look and a new row.
#[test]
#[cfg_attr(not(feature = "elf-tests"), ignore = "reads the ELF: cargo fw, then cargo fw-test")]
fn it_weighs_what_the_table_says() {
    let firmware = Firmware::read();
    let elf = firmware.elf();
    let comment = elf.section_by_name(".comment").expect("the compiler's name").data().expect("readable");
    let comment = String::from_utf8_lossy(comment).into_owned();
    let table = include_str!("../figures.csv");
    let (loadable, ram) = sizes(&firmware);
    for row in table.lines().skip(1) {
        let fields: Vec<&str> = row.split(',').collect();
        if !comment.contains(&format!("{} ", fields[0])) {
            continue;
        }
        for (name, now, then) in [("loadable bytes", loadable, fields[1]), ("static RAM", ram, fields[2])] {
            let then: u64 = then.parse().expect("a number");
            assert!(now.abs_diff(then) * 50 <= then, "{name}: {now}, the table says {then}");
        }
        return;
    }
    println!("no row for this compiler: {comment}");
}
