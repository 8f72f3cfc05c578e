//! The page as a program serves it: the same parts as files beside each other, so that nothing in it is a
//! script by itself. It asks the program what the page from a file asks its own module.

use super::{MODULES, PAGE, PLOT, bundle, filled, flush, style};

/// What a browser may do with the page: load what lies beside it, and speak to who served it.
pub const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
                          img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A file that is served.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// In the page's folder.
    pub name: &'static str,
    /// Its media type.
    pub kind: &'static str,
    /// What is in it.
    pub text: String,
}

/// All of them; the page itself has no name.
#[must_use]
pub fn files() -> Vec<File> {
    let script = "text/javascript; charset=utf-8";
    vec![
        File { name: "", kind: "text/html; charset=utf-8", text: page() },
        File { name: "style.css", kind: "text/css; charset=utf-8", text: style() },
        File { name: "uplot.js", kind: script, text: PLOT.to_owned() },
        File { name: "app.js", kind: script, text: bundle::bundle(&MODULES, "app.js") },
    ]
}

fn page() -> String {
    let parts = [
        ("<style>/*STYLE*/</style>", "<link rel=\"stylesheet\" href=\"style.css\">".to_owned()),
        ("/*WASM*/", String::new()),
        ("/*WORKER*/", String::new()),
        (
            "<script type=\"application/octet-stream\" id=\"uplot\">/*UPLOT*/</script>",
            "<script id=\"uplot\" src=\"uplot.js\"></script>".to_owned(),
        ),
        ("/*APP*/", String::new()),
        (
            "<script type=\"module\">/*BOOT*/</script>",
            "<script type=\"module\" src=\"app.js\"></script>".to_owned(),
        ),
    ];
    // What it may do its server says.
    let without = PAGE.lines().filter(|line| !line.contains("Content-Security-Policy"));
    filled(&flush(&without.collect::<Vec<_>>().join("\n")), &parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_the_page_is_a_script_or_a_style_by_itself() {
        let page = &files()[0].text;
        for (tag, closed) in [("<style", "</style>"), (" style=", ""), (" onclick", "")] {
            assert!(!page.contains(tag), "{tag} {closed}");
        }
        for script in page.split("<script").skip(1) {
            let (head, body) = script.split_once('>').unwrap();
            let body = body.split("</script>").next().unwrap();
            assert!(body.is_empty(), "{head}: {body}");
        }
        for file in &files()[1..] {
            assert!(page.contains(&format!("\"{}\"", file.name)), "{}", file.name);
        }
    }
}
