//! Rust source as words: comments and the insides of strings are gone, each word knows its line.

/// An identifier, `::`, a string (as `"`), or one character of punctuation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Token {
    pub text: String,
    pub line: usize,
}

impl Token {
    pub fn is_name(&self) -> bool {
        self.text.starts_with(|c: char| c.is_alphabetic() || c == '_')
    }
}

/// The words of a source, in order.
pub fn tokens(source: &str) -> Vec<Token> {
    let mut scanner = Scanner { rest: source, line: 1, found: Vec::new() };
    while scanner.step() {}
    scanner.found
}

struct Scanner<'a> {
    rest: &'a str,
    line: usize,
    found: Vec<Token>,
}

impl Scanner<'_> {
    fn step(&mut self) -> bool {
        let Some(first) = self.rest.chars().next() else { return false };
        if self.rest.starts_with("//") {
            self.skip(self.rest.find('\n').unwrap_or(self.rest.len()));
        } else if self.rest.starts_with("/*") {
            self.skip(block_comment(self.rest));
        } else if let Some(length) = string(self.rest) {
            self.take(length, "\"");
        } else if first == '\'' {
            let length = quote(self.rest);
            self.take(length, "'");
        } else if first.is_alphanumeric() || first == '_' {
            let length = self.rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(self.rest.len());
            let word = self.rest[..length].to_string();
            self.take(length, &word);
        } else if self.rest.starts_with("::") {
            self.take(2, "::");
        } else if first.is_whitespace() {
            self.skip(first.len_utf8());
        } else {
            self.take(first.len_utf8(), &first.to_string());
        }
        true
    }

    fn take(&mut self, length: usize, text: &str) {
        self.found.push(Token { text: text.to_string(), line: self.line });
        self.skip(length);
    }

    fn skip(&mut self, length: usize) {
        self.line += self.rest[..length].matches('\n').count();
        self.rest = &self.rest[length..];
    }
}

fn block_comment(rest: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < rest.len() {
        let here = &rest.as_bytes()[at..];
        if here.starts_with(b"/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if here.starts_with(b"*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    rest.len()
}

/// The length of the string that stands here, if one does: `".."`, `r#".."#`, and both with `b` or `c` before them.
fn string(rest: &str) -> Option<usize> {
    let prefix = rest.len() - rest.trim_start_matches(['b', 'c', 'r']).len();
    let (before, body) = rest.split_at(prefix);
    if prefix > 2 {
        return None;
    }
    if before.ends_with('r') {
        let hashes = body.len() - body.trim_start_matches('#').len();
        let inside = body[hashes..].strip_prefix('"')?;
        let end = format!("\"{}", "#".repeat(hashes));
        return Some(prefix + hashes + 1 + inside.find(&end).map_or(inside.len(), |at| at + end.len()));
    }
    let inside = body.strip_prefix('"')?;
    let mut escaped = false;
    for (at, byte) in inside.bytes().enumerate() {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = true,
            b'"' => return Some(prefix + 1 + at + 1),
            _ => {}
        }
    }
    Some(rest.len())
}

/// The length of a character such as `'x'` or `'\n'`; of a lifetime only its quote.
fn quote(rest: &str) -> usize {
    let mut inside = rest[1..].char_indices();
    match (inside.next(), inside.next()) {
        (Some((_, '\\')), Some((at, escaped))) => {
            let from = 1 + at + escaped.len_utf8();
            rest[from..].find('\'').map_or(rest.len(), |end| from + end + 1)
        }
        (Some(_), Some((at, '\''))) => 1 + at + 1,
        _ => 1,
    }
}

/// The words that are compiled into a program: items under `#[cfg(test)]` and `#[cfg(all(test, ..))]` are left out.
pub fn without_tests(tokens: &[Token]) -> Vec<Token> {
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if let Some(attribute) = test_attribute(&tokens[at..]) {
            at += attribute + item(&tokens[at + attribute..]);
        } else {
            kept.push(tokens[at].clone());
            at += 1;
        }
    }
    kept
}

/// The number of words of the attribute that stands here, if it keeps an item for tests.
fn test_attribute(tokens: &[Token]) -> Option<usize> {
    let starts = |texts: &[&str]| tokens.len() > texts.len() && tokens.iter().zip(texts).all(|(a, b)| a.text == *b);
    if !starts(&["#", "[", "cfg", "(", "test", ")"]) && !starts(&["#", "[", "cfg", "(", "all", "(", "test"]) {
        return None;
    }
    Some(tokens.iter().position(|token| token.text == "]")? + 1)
}

/// The number of words of an item: to its `;` or `,`, or to the end of its braces.
fn item(tokens: &[Token]) -> usize {
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate() {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => {
                depth -= 1;
                if depth == 0 && token.text == "}" {
                    return at + 1;
                }
            }
            ";" | "," if depth == 0 => return at + 1,
            _ => {}
        }
    }
    tokens.len()
}

#[test]
fn words_are_found_between_comments_strings_and_lifetimes() {
    let source =
        "use a::b; // use c\n/* x /* y */ z */ fn f<'a>(c: &'a str) { g(\"h::i\", '\\'', 'j', r#\"k \" l\"#) }";
    let found = tokens(source);
    let names: Vec<&str> = found.iter().filter(|token| token.is_name()).map(|token| token.text.as_str()).collect();
    assert_eq!(names, ["use", "a", "b", "fn", "f", "a", "c", "a", "str", "g"]);
    assert_eq!(found.last().unwrap().line, 2);
}

#[test]
fn tests_are_left_out() {
    let source = "use a::b; #[cfg(test)] mod tests { use c::d; } #[cfg(test)] mod more; #[cfg(all(test, not(x)))] fn f() {} fn e() {}";
    let kept = without_tests(&tokens(source));
    let names: Vec<&str> = kept.iter().filter(|token| token.is_name()).map(|token| token.text.as_str()).collect();
    assert_eq!(names, ["use", "a", "b", "fn", "e"]);
}
