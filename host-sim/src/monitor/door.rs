//! Who may come in. A page of somebody else that is open in the same browser can send requests here, too, and
//! by a name of its own that leads to this machine (DNS rebinding) even read what is answered. So a visitor
//! must know the token of the address, must have come by this machine's own address and, where a browser says
//! from which page, from this one.

use std::net::{IpAddr, SocketAddr};

/// What a request says of where it comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Knock<'a> {
    /// The path, with the token.
    pub path: &'a str,
    /// The header `Host`.
    pub host: Option<&'a str>,
    /// The header `Origin`: of which page it is.
    pub origin: Option<&'a str>,
    /// It is to become a conversation, or brings something: what a browser lets any page begin.
    pub begins: bool,
}

/// The door of a program that listens.
#[derive(Debug, Clone)]
pub struct Door {
    token: String,
    at: SocketAddr,
}

impl Door {
    /// At an address, with a new token: 128 bits from the system.
    ///
    /// # Errors
    ///
    /// If the system has no random numbers.
    pub fn new(at: SocketAddr) -> Result<Self, getrandom::Error> {
        let mut bits = [0_u8; 16];
        getrandom::fill(&mut bits)?;
        let token = bits.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { token, at })
    }

    /// Where the page is.
    #[must_use]
    pub fn url(&self) -> String {
        let shown = if self.at.ip().is_unspecified() { IpAddr::from([127, 0, 0, 1]) } else { self.at.ip() };
        format!("http://{}/{}/", SocketAddr::new(shown, self.at.port()), self.token)
    }

    /// What is asked for behind the token, or why nobody comes in.
    ///
    /// # Errors
    ///
    /// What is wrong, in words for whoever has typed the address.
    pub fn opens<'a>(&self, knock: &Knock<'a>) -> Result<&'a str, &'static str> {
        let host = knock.host.ok_or("a request without a Host")?;
        if !self.is_ours(host) {
            return Err("the address is not this machine's own: use the one that host-sim monitor printed");
        }
        match knock.origin {
            Some(origin) if origin.strip_prefix("http://") != Some(host) => {
                return Err("another page asks, not this one");
            }
            None if knock.begins => return Err("no page asks"),
            _ => {}
        }
        let wrong =
            "the token is missing or not the right one: use the address that host-sim monitor printed";
        let (token, rest) =
            knock.path.strip_prefix('/').and_then(|path| path.split_once('/')).ok_or(wrong)?;
        if self.knows(token) { Ok(rest) } else { Err(wrong) }
    }

    /// However wrong, it takes the same time.
    fn knows(&self, token: &str) -> bool {
        let differs = token.bytes().zip(self.token.bytes()).fold(0, |differs, (a, b)| differs | (a ^ b));
        token.len() == self.token.len() && differs == 0
    }

    /// An address as such, no name: a name can lead anywhere.
    fn is_ours(&self, host: &str) -> bool {
        let local = format!("localhost:{}", self.at.port());
        let Ok(named) = host.parse::<SocketAddr>() else { return host == local && self.is_near() };
        let ip = if self.at.ip().is_unspecified() { named.ip() } else { self.at.ip() };
        named == SocketAddr::new(ip, self.at.port())
            || named.port() == self.at.port() && self.same_machine(named)
    }

    fn same_machine(&self, named: SocketAddr) -> bool {
        self.at.ip().is_loopback() && named.ip().is_loopback()
    }

    /// It is reached from this machine by the name that every machine has for itself.
    fn is_near(&self) -> bool {
        self.at.ip().is_loopback() || self.at.ip().is_unspecified()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn door(at: &str) -> Door {
        Door { token: "0123".to_owned(), at: at.parse().unwrap() }
    }

    #[test]
    fn only_this_machines_address_this_page_and_the_token_open() {
        let near = door("127.0.0.1:8000");
        let ours = Knock {
            path: "/0123/socket",
            host: Some("127.0.0.1:8000"),
            origin: Some("http://127.0.0.1:8000"),
            begins: true,
        };
        assert_eq!(near.opens(&ours), Ok("socket"));
        let local = Knock { host: Some("localhost:8000"), origin: Some("http://localhost:8000"), ..ours };
        assert_eq!(near.opens(&local), Ok("socket"));
        assert_eq!(near.opens(&Knock { path: "/0123/", origin: None, begins: false, ..ours }), Ok(""));
        for (wrong, why) in [
            (Knock { host: None, ..ours }, "Host"),
            (
                Knock { host: Some("evil.example:8000"), origin: Some("http://evil.example:8000"), ..ours },
                "own",
            ),
            (Knock { host: Some("192.168.1.7:8000"), ..ours }, "own"),
            (Knock { host: Some("127.0.0.1:8001"), ..ours }, "own"),
            (Knock { origin: Some("http://evil.example"), ..ours }, "another page"),
            (Knock { origin: Some("https://127.0.0.1:8000"), ..ours }, "another page"),
            (Knock { origin: Some("null"), ..ours }, "another page"),
            (Knock { origin: None, ..ours }, "no page"),
            (Knock { path: "/", ..ours }, "token"),
            (Knock { path: "/0124/socket", ..ours }, "token"),
            (Knock { path: "/012/socket", ..ours }, "token"),
            (Knock { path: "//socket", ..ours }, "token"),
        ] {
            assert!(near.opens(&wrong).unwrap_err().contains(why), "{wrong:?}");
        }
    }

    #[test]
    fn in_a_network_any_address_opens_and_no_name_does() {
        let far = door("0.0.0.0:8000");
        let by = |host| Knock { path: "/0123/", host: Some(host), ..Knock::default() };
        assert!(far.opens(&by("192.168.1.7:8000")).is_ok() && far.opens(&by("lab.example:8000")).is_err());
        assert_eq!(far.url(), "http://127.0.0.1:8000/0123/");
        let one = door("192.168.1.7:8000");
        assert!(one.opens(&by("192.168.1.7:8000")).is_ok() && one.opens(&by("192.168.1.8:8000")).is_err());
    }

    #[test]
    fn no_two_programs_have_the_same_token() {
        let at: SocketAddr = "127.0.0.1:80".parse().unwrap();
        let (one, other) = (Door::new(at).unwrap(), Door::new(at).unwrap());
        assert!(one.token != other.token && one.token.len() == 32);
    }
}
