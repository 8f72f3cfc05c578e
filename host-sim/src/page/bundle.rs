//! ES modules as one script: each becomes a function that gives what it exports. A page opened from a file
//! may not load modules of its own.
//!
//! The page's modules keep to the little that this reads: `import { a, b } from "./x.js";`, and `export`
//! before a `class`, `const`, `function` or `async function`, both at the beginning of a line. Comments that
//! are lines of their own are left out, and what `/** ... */` says of types within a line.

use std::borrow::Cow;
use std::collections::BTreeSet;

/// A module's name and text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Module {
    pub(super) name: &'static str,
    pub(super) text: &'static str,
}

/// The module `entry` with all that it needs, as one script.
pub(super) fn bundle(modules: &[Module], entry: &str) -> String {
    let mut script = String::from("\"use strict\";\n");
    add(modules, entry, &mut BTreeSet::new(), &mut script);
    script
}

/// Adds a module after those that it needs, unless it is there.
fn add(modules: &[Module], name: &str, there: &mut BTreeSet<String>, script: &mut String) {
    if !there.insert(name.to_owned()) {
        return;
    }
    let module = modules.iter().find(|module| module.name == name);
    let module = module.unwrap_or_else(|| panic!("the page has no module {name}"));
    let (mut body, mut exports) = (String::new(), Vec::new());
    for line in code(module.text) {
        let line = bare(line);
        let line = line.as_ref();
        if let Some((names, from)) = import(line) {
            add(modules, from, there, script);
            body.push_str(&format!("const {{{names}}} = {};\n", variable(from)));
        } else if let Some(rest) = line.strip_prefix("export ") {
            exports.push(declared(rest).to_owned());
            body.push_str(rest);
            body.push('\n');
        } else {
            body.push_str(line);
            body.push('\n');
        }
    }
    let exports = exports.join(", ");
    script
        .push_str(&format!("const {} = (() => {{\n{body}return {{ {exports} }};\n}})();\n", variable(name)));
}

/// The lines that do something, without their indent: not those that are all comment, and not the empty ones.
fn code(text: &str) -> impl Iterator<Item = &str> {
    let mut within = false;
    text.lines().map(str::trim).filter(move |line| {
        let begins = line.starts_with("/**");
        let comment = within || begins && (line.ends_with("*/") || !line.contains("*/"));
        within = (within || begins) && !line.contains("*/");
        !(comment || line.is_empty() || line.starts_with("//"))
    })
}

/// A line without `/** ... */`.
fn bare(line: &str) -> Cow<'_, str> {
    let Some((before, rest)) = line.split_once("/**") else { return line.into() };
    let Some((_, after)) = rest.split_once("*/") else { return line.into() };
    (before.to_owned() + &bare(after.trim_start())).into()
}

/// What a line imports, and from where.
fn import(line: &str) -> Option<(&str, &str)> {
    let (names, from) = line.strip_prefix("import {")?.split_once("} from \"./")?;
    Some((names, from.strip_suffix("\";")?))
}

/// The name that is declared.
fn declared(rest: &str) -> &str {
    let name =
        ["class ", "const ", "function ", "async function "].iter().find_map(|kind| rest.strip_prefix(kind));
    let name = name.unwrap_or_else(|| panic!("'export {rest}' declares nothing that can be bundled"));
    name.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default()
}

/// What a module is called in the script.
fn variable(name: &str) -> String {
    format!("module_{}", name.trim_end_matches(".js").replace('-', "_"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_needed_comes_first_and_once() {
        let adds = "/** Adds.\n * @param {number} x\n */\nexport function f(x) {\n  // One more.\n  \
                    return /** @type {number} */ (x) + /** @type {any} */ (c);\n}\n";
        let both = "import { f } from \"./b-b.js\";\nimport { c } from \"./c.js\";\nf(c);\n";
        let b = String::from("import { c } from \"./c.js\";\n") + adds;
        let modules = [
            Module { name: "a.js", text: both },
            Module { name: "b-b.js", text: b.leak() },
            Module { name: "c.js", text: "export const c = 1;\n" },
        ];
        let lines = [
            "\"use strict\";",
            "const module_c = (() => {",
            "const c = 1;",
            "return { c };",
            "})();",
            "const module_b_b = (() => {",
            "const { c } = module_c;",
            "function f(x) {",
            "return (x) + (c);",
            "}",
            "return { f };",
            "})();",
            "const module_a = (() => {",
            "const { f } = module_b_b;",
            "const { c } = module_c;",
            "f(c);",
            "return {  };",
            "})();",
            "",
        ];
        let expected = lines.join("\n");
        assert_eq!(bundle(&modules, "a.js"), expected);
    }
}
