//! From the text to steps.

use super::meaning::{Meaning, meaning};
use super::{APART, DECLARED};
use std::collections::{BTreeMap, HashMap};

#[derive(Debug)]
pub(crate) struct Program {
    pub(crate) kernels: HashMap<String, Kernel>,
    /// What the module declares with its values, and \[bytes\] how much of a block's memory.
    pub(crate) constants: Vec<u8>,
    pub(crate) shared: usize,
}

#[derive(Debug, Default)]
pub(crate) struct Kernel {
    /// \[bytes\] Where each is among them, and how long.
    pub(crate) parameters: Vec<(usize, usize)>,
    pub(crate) steps: Vec<Instruction>,
    /// The instructions' lines in the text, counted from 1, and their names.
    pub(crate) places: Vec<(usize, String)>,
    /// \[bits\] Of each register.
    pub(crate) widths: Vec<u32>,
}

#[derive(Debug)]
pub(crate) struct Instruction {
    /// It is executed where this register is as it says.
    pub(crate) guard: Option<(usize, bool)>,
    pub(crate) what: Step,
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Operand {
    Register(usize),
    Number(u64),
    Special(usize),
}

#[derive(Debug)]
pub(crate) enum Step {
    Compute { to: usize, meaning: Meaning, from: [Operand; 4] },
    Parameter { to: usize, place: usize, size: usize },
    Load { to: usize, base: Operand, offset: u64, size: usize },
    Store { base: Operand, offset: u64, size: usize, from: Operand },
    Halves { to: [usize; 2], from: Operand },
    Branch(usize),
    Table { index: Operand, to: Vec<usize> },
    Exit,
    Trap,
}

/// While a kernel is read.
struct Reader<'a> {
    kernel: Kernel,
    known: HashMap<&'a str, usize>,
    parameters: HashMap<&'a str, usize>,
    labels: HashMap<&'a str, usize>,
    tables: HashMap<&'a str, Vec<&'a str>>,
    /// Addresses of what the module declares.
    declared: &'a BTreeMap<&'a str, u64>,
}

impl Program {
    pub(crate) fn of(text: &str) -> Self {
        let (mut constants, mut shared, mut declared) = (Vec::new(), 0, BTreeMap::new());
        for line in text.lines().map(str::trim) {
            let Some((head, name, size)) = declaration(line) else { continue };
            if head.starts_with(".shared") {
                declared.insert(name, APART + shared as u64);
                shared += size;
            } else if head.starts_with(".global") {
                declared.insert(name, constants.len() as u64);
                let (_, values) = line.split_once('{').expect("values");
                let values = values.trim_end_matches(['}', ';']).split(',');
                constants.extend(values.map(|value| value.trim().parse::<u8>().expect("a byte")));
            }
        }
        assert!(constants.len().max(shared) < APART as usize && DECLARED == 2);
        let entries = text.split(".visible .entry ").skip(1);
        let line_of = |part: &str| text[..part.as_ptr() as usize - text.as_ptr() as usize].lines().count();
        let kernels = entries.map(|entry| {
            let (name, rest) = entry.split_once('(').expect("parameters");
            let (parameters, rest) = rest.split_once(')').expect("their end");
            let body = rest.split("// -- End function").next().unwrap_or_default();
            (name.to_owned(), Reader::kernel(parameters, body, line_of(body), &declared))
        });
        Self { kernels: kernels.collect(), constants, shared }
    }
}

/// Such as `.shared .align 4 .b8 name[12];`: what stands before the name, the name, \[bytes\] how long.
fn declaration(line: &str) -> Option<(&str, &str, usize)> {
    let (before, after) = line.split_once('[')?;
    let (head, name) = before.rsplit_once(".b8 ")?;
    Some((head, name, after.split(']').next()?.parse().ok()?))
}

impl<'a> Reader<'a> {
    /// Whose body begins in this `line`.
    fn kernel(
        parameters: &'a str,
        body: &'a str,
        line: usize,
        declared: &'a BTreeMap<&'a str, u64>,
    ) -> Kernel {
        let none = HashMap::new;
        let mut reader = Self {
            kernel: Kernel::default(),
            known: none(),
            parameters: none(),
            labels: none(),
            tables: HashMap::new(),
            declared,
        };
        let mut end = 0;
        for line in parameters.split(',').map(str::trim) {
            let (name, size) = match declaration(line) {
                Some((_, name, size)) => (name, size),
                None => (line.rsplit(' ').next().unwrap_or(line), if line.contains(".u64") { 8 } else { 4 }),
            };
            let place = usize::next_multiple_of(end, size.min(8));
            reader.parameters.insert(name, place);
            reader.kernel.parameters.push((place, size));
            end = place + size;
        }
        let statements = reader.statements(body);
        for (at, statement) in statements {
            let (name, instruction) = reader.instruction(statement);
            reader.kernel.places.push((line + at, name.to_owned()));
            reader.kernel.steps.push(instruction);
        }
        reader.kernel
    }

    /// Takes note of labels, tables and registers; gives the instructions' text, and
    /// in which line of the body they are.
    fn statements(&mut self, body: &'a str) -> Vec<(usize, &'a str)> {
        let (mut statements, mut table) = (Vec::new(), None);
        for (at, line) in body.lines().enumerate() {
            let line = line.split("//").next().unwrap_or_default().trim();
            if let Some((name, ".branchtargets")) = line.split_once(": ") {
                table = Some(name);
                self.tables.insert(name, Vec::new());
            } else if let Some(name) = table {
                let target = line.trim_end_matches([',', ';']);
                self.tables.entry(name).or_default().push(target);
                table = table.filter(|_| !line.ends_with(';'));
            } else if let Some(label) = line.strip_suffix(':') {
                self.labels.insert(label, statements.len());
            } else {
                // A scope of its own is not needed: names in one are not used twice with another width.
                let line = line.strip_prefix("{ ").unwrap_or(line);
                let line = line.strip_suffix("; }").unwrap_or(line);
                for statement in line.split(';').map(str::trim) {
                    match statement.strip_prefix(".reg ") {
                        Some(registers) => self.declare(registers),
                        None if statement.contains(['.', ' '])
                            || ["ret", "exit", "trap"].contains(&statement) =>
                        {
                            statements.push((at, statement));
                        }
                        None => {}
                    }
                }
            }
        }
        statements
    }

    /// Such as `.b64 begin`; those of the whole kernel, such as `.b32 %r<12>`, are known by their names.
    fn declare(&mut self, text: &'a str) {
        let (kind, name) = text.split_once([' ', '\t']).expect("a kind and a name");
        if !name.contains('<') {
            self.register(name.trim(), kind);
        }
    }

    fn register(&mut self, name: &'a str, kind: &str) -> usize {
        let width = match kind {
            ".pred" | "%p" => 1,
            ".b16" | "%rs" => 16,
            ".b32" | "%r" => 32,
            ".b64" | "%rd" => 64,
            _ => panic!("{kind} {name}"),
        };
        let widths = &mut self.kernel.widths;
        *self.known.entry(name).or_insert_with(|| {
            widths.push(width);
            widths.len() - 1
        })
    }

    fn to(&mut self, name: &'a str) -> usize {
        if let Some(known) = self.known.get(name) {
            return *known;
        }
        let kind = name.trim_end_matches(|c: char| c.is_ascii_digit());
        self.register(name, kind)
    }

    fn operand(&mut self, text: &'a str) -> Operand {
        let special = ["%ctaid.x", "%ntid.x", "%tid.x"];
        if let Some(k) = special.iter().position(|name| *name == text) {
            return Operand::Special(k);
        }
        if let Some(address) = self.declared.get(text) {
            return Operand::Number(*address);
        }
        if let Some(hex) = text.strip_prefix("0f").or_else(|| text.strip_prefix("0d")) {
            return Operand::Number(u64::from_str_radix(hex, 16).expect("the bits of a number"));
        }
        match text.parse::<i128>() {
            Ok(number) => Operand::Number(number as u64),
            Err(_) => Operand::Register(self.to(text)),
        }
    }

    /// Such as `[%rd3+12]`: what it begins with, and how far beyond.
    fn address(text: &'a str) -> (&'a str, u64) {
        let inner = text.strip_prefix('[').and_then(|t| t.strip_suffix(']')).expect("an address");
        let (base, offset) = inner.split_once('+').unwrap_or((inner, "0"));
        (base, offset.parse::<i64>().expect("an offset") as u64)
    }

    fn instruction(&mut self, statement: &'a str) -> (&'a str, Instruction) {
        let (guard, rest) = match statement.strip_prefix('@') {
            Some(guarded) => {
                let (guard, rest) = guarded.split_once(' ').expect("a guard");
                let name = guard.trim_start_matches('!');
                (Some((self.to(name), name == guard)), rest.trim())
            }
            None => (None, statement),
        };
        let (name, rest) = rest.split_once([' ', '\t']).unwrap_or((rest, ""));
        // Two halves in braces are two operands.
        let list: Vec<&str> = rest.split([',', '{', '}']).map(str::trim).filter(|o| !o.is_empty()).collect();
        (name, Instruction { guard, what: self.step(name, rest, &list) })
    }

    fn step(&mut self, name: &str, rest: &str, list: &[&'a str]) -> Step {
        let size = || match name.rsplit('.').next() {
            Some("b8") => 1,
            Some("b32") => 4,
            Some("b64") => 8,
            _ => panic!("{name}"),
        };
        match (name, list) {
            ("ret" | "exit", []) => Step::Exit,
            ("trap", []) => Step::Trap,
            ("bra" | "bra.uni", [label]) => Step::Branch(self.labels[label]),
            ("brx.idx", [index, table]) => {
                let to = self.tables[table].iter().map(|label| self.labels[label]).collect();
                Step::Table { index: self.operand(index), to }
            }
            ("ld.param.b32" | "ld.param.b64" | "ld.param.b8", [to, address]) => {
                let (base, offset) = Self::address(address);
                let place = self.parameters[base] + offset as usize;
                Step::Parameter { to: self.to(to), place, size: size() }
            }
            (load, [to, address]) if load.starts_with("ld.") => {
                let (base, offset) = Self::address(address);
                Step::Load { to: self.to(to), base: self.operand(base), offset, size: size() }
            }
            (store, [address, from]) if store.starts_with("st.") => {
                let (base, offset) = Self::address(address);
                Step::Store { base: self.operand(base), offset, size: size(), from: self.operand(from) }
            }
            ("mov.b64", [low, high, from]) if rest.starts_with('{') => {
                Step::Halves { to: [self.to(low), self.to(high)], from: self.operand(from) }
            }
            ("mov.b64", [to, low, high]) => self.compute("join.b64", to, &[low, high]),
            (_, [to, from @ ..]) => self.compute(name, to, from),
            _ => panic!("{name} {list:?}"),
        }
    }

    fn compute(&mut self, name: &str, to: &'a str, from: &[&'a str]) -> Step {
        let meaning = meaning(name).unwrap_or_else(|| panic!("{name} is not known"));
        let mut operands = [Operand::Number(0); 4];
        for (place, text) in operands.iter_mut().zip(from) {
            *place = self.operand(text);
        }
        Step::Compute { to: self.to(to), meaning, from: operands }
    }
}
