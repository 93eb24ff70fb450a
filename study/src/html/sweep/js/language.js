// Expressions over the columns of a point, with the meaning that `exclude` gives them in a plan (`plan/filter.rs`): or, and, not,
// comparisons (= is ==), in and not in, is none, + - * / // %, lists, parentheses, words in quotes, sizes such as 16KiB. Values are
// ordered as there: none before flags before numbers before words. What it cannot read is an error with its place; it never guesses.
"use strict";
sweep.language = (() => {
  const UNITS = { B: 1, KiB: 1024, MiB: 1048576 };
  const KEYWORDS = new Set(["and", "or", "not", "in", "is", "if", "else"]);
  const CONSTANTS = new Map([["true", true], ["True", true], ["false", false], ["False", false], ["none", null], ["None", null]]);
  const TOKEN = /\s*(?:("(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')|(\d[\w.]*(?:(?<=[eE])[+-]\d+)?)|([A-Za-z_]\w*)|(<=|>=|==|!=|\/\/|\*\*|[-+*/%<>=()[\],]))/y;

  /** An error with the place of what is wrong: characters from `at`. */
  const fail = (text, at, why) => {
    const rest = text.slice(at).trim();
    const word = /^(?:[\w.]+|"[^"]*"?|'[^']*'?|\S)/.exec(rest)?.[0];
    const error = new Error(word ? `at character ${at + text.slice(at).indexOf(rest) + 1}, ${word}: ${why}` : `at the end: ${why}`);
    error.at = at;
    throw error;
  };

  const ESCAPES = { n: "\n", t: "\t", r: "\r", b: "\b", f: "\f", "\\": "\\", "/": "/", "'": "'", '"': '"' };
  const unquote = (text, at, given) => given.slice(1, -1).replace(/\\(.)/gs, (_, own) => ESCAPES[own] ?? fail(text, at, `there is no escape \\${own}`));

  const quantity = (text, at, given) => {
    // Columns of such numbers are words here: no number holds them.
    if (/^\d+$/.test(given) && !Number.isSafeInteger(Number(given))) return given;
    if (/^\d+(\.\d+)?([eE][+-]?\d+)?$/.test(given)) return Number(given);
    const size = /^(\d+)([A-Za-z]+)$/.exec(given);
    if (size && Object.hasOwn(UNITS, size[2])) return Number(size[1]) * UNITS[size[2]];
    return fail(text, at, "no number; write 3, 0.5, 1e6 or a size such as 16KiB (units are B, KiB, MiB)");
  };

  const tokens = (text) => {
    const found = [];
    TOKEN.lastIndex = 0;
    for (;;) {
      const start = TOKEN.lastIndex;
      const match = TOKEN.exec(text);
      if (!match) {
        if (text.slice(start).trim() === "") return [...found, { kind: "end", at: text.length }];
        const open = /^\s*["']/.test(text.slice(start));
        const part = /^\s*~/.test(text.slice(start));
        fail(text, start, open ? "the quote is not closed" : part ? 'a part of a word is looked for as "part" in column' : "this is not read here");
      }
      const [whole, word, number, name, sign] = match;
      const at = start + whole.length - whole.trimStart().length;
      // A size may stand in quotes, as plans write values of axes.
      if (word !== undefined) found.push({ kind: "value", value: /^.\d+(B|KiB|MiB).$/.test(word) ? quantity(text, at, word.slice(1, -1)) : unquote(text, at, word), at });
      else if (number !== undefined) found.push({ kind: "value", value: quantity(text, at, number), at });
      else if (name !== undefined) found.push(KEYWORDS.has(name) ? { kind: name, at } : CONSTANTS.has(name) ? { kind: "value", value: CONSTANTS.get(name), at } : { kind: "name", name, at });
      else found.push({ kind: sign === "=" ? "==" : sign, at });
    }
  };

  // The meaning of operators.
  const truth = (own) => own !== null && own !== false && own !== 0 && own !== "" && !(Array.isArray(own) && own.length === 0);
  const rank = (own) => (own === null ? 1 : typeof own === "boolean" ? 2 : typeof own === "number" ? 3 : typeof own === "string" ? 4 : 5);
  const isNumber = (own) => typeof own === "number" || typeof own === "boolean";
  // Results with a fraction have only some of their digits on this page; how many, each comparison says before it compares.
  let tolerance = 0;
  const near = (a, b) => a === b || (!(Number.isInteger(a) && Number.isInteger(b)) && Number.isFinite(a) && Number.isFinite(b) && Math.abs(a - b) <= tolerance * Math.max(Math.abs(a), Math.abs(b)));
  const equal = (a, b) => {
    if (isNumber(a) && isNumber(b)) return near(Number(a), Number(b));
    if (Array.isArray(a) && Array.isArray(b)) return Boolean(a.isTuple) === Boolean(b.isTuple) && a.length === b.length && a.every((own, i) => equal(own, b[i]));
    return a === b;
  };
  const order = (a, b) => {
    if (rank(a) !== rank(b)) return rank(a) - rank(b);
    if (rank(a) === 5) throw new Error("lists have no order");
    if (typeof a === "string") {
      // By characters, not by the halves of those that take two.
      const [x, y] = [[...a], [...b]];
      for (let i = 0; i < x.length && i < y.length; i += 1) if (x[i] !== y[i]) return x[i].codePointAt(0) - y[i].codePointAt(0);
      return x.length - y.length;
    }
    return a === null || equal(a, b) ? 0 : Number(a) - Number(b);
  };
  const contains = (list, own) => {
    if (Array.isArray(list)) return list.some((one) => equal(one, own));
    if (typeof list === "string" && typeof own === "string") return list.includes(own);
    throw new Error("in looks into a list or, for a word, into a word");
  };
  const COMPARE = {
    "==": equal, "!=": (a, b) => !equal(a, b), "<": (a, b) => order(a, b) < 0, "<=": (a, b) => order(a, b) <= 0,
    ">": (a, b) => order(a, b) > 0, ">=": (a, b) => order(a, b) >= 0, in: (a, b) => contains(b, a), "not in": (a, b) => !contains(b, a),
  };
  const divisor = (b) => { if (b === 0) throw new Error("division by zero"); return b; };
  const MATH = {
    "+": (a, b) => a + b, "-": (a, b) => a - b, "*": (a, b) => a * b, "/": (a, b) => a / divisor(b),
    "//": (a, b) => Math.floor(a / divisor(b)), "%": (a, b) => { const rest = a % divisor(b); return rest !== 0 && (rest < 0) !== (b < 0) ? rest + b : rest; },
  };
  const calculate = (sign, a, b) => {
    if (sign === "+" && typeof a === "string" && typeof b === "string") return a + b;
    if (sign === "*" && typeof a === "string" && Number.isInteger(b) && b >= 0 && b <= 64) return a.repeat(b);
    if (!isNumber(a) || !isNumber(b)) throw new Error(`${sign} takes two numbers`);
    return MATH[sign](Number(a), Number(b));
  };

  // The bounds of `exclude`, which counts the same (`bounded` in `plan/filter.rs`; brackets in brackets are its parser's bound): what
  // is longer or deeper would need a deep stack.
  const LENGTH_MAX = 10000, SIGNS_MAX = 200, DEPTH_MAX = 74;
  const SIGN = /[-+*/%~|.([{<>=]|[\p{Alphabetic}\p{N}_]+/gu;
  const JOINING = new Set(["not", "if", "and", "or"]);

  /** Refuses what is too long or has too many signs. */
  const bounded = (text) => {
    const all = [...text];
    if (all.length > LENGTH_MAX) fail(text, all.slice(0, LENGTH_MAX).join("").length, `an expression has at most ${LENGTH_MAX} characters`);
    let signs = 0;
    for (const { 0: sign, index } of text.matchAll(SIGN)) {
      if (/^[\p{Alphabetic}\p{N}_]/u.test(sign) && !JOINING.has(sign)) continue;
      signs += 1;
      if (signs > SIGNS_MAX) fail(text, index, `an expression has at most ${SIGNS_MAX} signs and brackets`);
    }
  };

  /** A function from what gives the value of a name to the truth of the expression; `known` says which names there are, `digits` how
   * many of a column are kept, where these are not all. */
  const compile = (text, known, hint = () => "", digits = () => 7) => {
    bounded(text);
    const list = tokens(text);
    let next = 0, depth = 0, fewest = Infinity;
    const now = () => list[next];
    const take = (...kinds) => (kinds.includes(now().kind) ? list[next++] : null);
    const wanted = (kind) => take(kind) ?? fail(text, now().at, `${kind} is missing here`);
    /** `make` of a left and a right side, as long as one of these signs follows. */
    const chain = (inner, kinds, make) => () => {
      let left = inner();
      for (let sign = take(...kinds); sign; sign = take(...kinds)) { const [a, b, kind] = [left, inner(), sign.kind]; left = make(kind, a, b); }
      return left;
    };
    /** What `read` reads within a bracket that was opened at `at`. */
    const within = (at, read) => {
      depth += 1;
      if (depth > DEPTH_MAX) fail(text, at, `at most ${DEPTH_MAX} brackets stand in one another`);
      const all = read();
      depth -= 1;
      return all;
    };
    const items = (end) => {
      const all = [];
      while (now().kind !== end) { all.push(either()); if (!take(",")) break; }
      wanted(end);
      return all;
    };
    const tuple = () => {
      const all = [];
      if (now().kind !== ")") {
        const first = either();
        if (!take(",")) { wanted(")"); return first; }
        all.push(first);
      }
      all.push(...items(")"));
      return (of) => Object.assign(all.map((one) => one(of)), { isTuple: true });
    };
    const primary = () => {
      const own = now();
      if (take("value")) return () => own.value;
      if (take("name")) {
        if (!known(own.name)) fail(text, own.at, `there is no column ${own.name}${hint(own.name)}`);
        if (now().kind === "(") fail(text, now().at, "functions are not read here");
        fewest = Math.min(fewest, digits(own.name) ?? Infinity);
        return (of) => of(own.name);
      }
      if (take("[")) return within(own.at, () => { const all = items("]"); return (of) => all.map((one) => one(of)); });
      if (take("(")) return within(own.at, tuple);
      return fail(text, own.at, "a column, a number or a word in quotes is missing here");
    };
    const signed = () => {
      const minus = take("-");
      if (!minus) return primary();
      const inner = signed();
      return (of) => { const own = inner(of); if (typeof own !== "number") throw new Error("- takes a number"); return -own; };
    };
    const unary = () => {
      let own = signed();
      while (take("is")) {
        const [inner, not] = [own, take("not")];
        const test = now();
        if (!take("value") || test.value !== null) fail(text, test.at, "write is none, or ==");
        own = (of) => (inner(of) === null) === !not;
      }
      return own;
    };
    const math = (kind, a, b) => (of) => calculate(kind, a(of), b(of));
    const sum = chain(chain(unary, ["*", "/", "//", "%"], math), ["+", "-"], math);
    const comparison = () => {
      const outer = fewest;
      fewest = Infinity;
      const first = sum(), rest = [];
      for (;;) {
        let sign = take("==", "!=", "<", "<=", ">", ">=", "in")?.kind;
        if (!sign && take("not")) { wanted("in"); sign = "not in"; }
        if (!sign) break;
        rest.push([COMPARE[sign], sum()]);
      }
      const own = 5 * 10 ** -fewest;
      fewest = Math.min(fewest, outer);
      if (rest.length === 0) return first;
      // a < b < c is a < b and b < c.
      return (of) => {
        let left = first(of);
        return rest.every(([holds, side]) => { const right = side(of); tolerance = own; const does = holds(left, right); left = right; return does; });
      };
    };
    const negation = () => { if (!take("not")) return comparison(); const inner = negation(); return (of) => !truth(inner(of)); };
    const both = chain(negation, ["and"], (_, a, b) => (of) => { const own = a(of); return truth(own) ? b(of) : own; });
    const either = chain(both, ["or"], (_, a, b) => (of) => { const own = a(of); return truth(own) ? own : b(of); });
    const whole = either();
    if (now().kind !== "end") fail(text, now().at, "and, or or a comparison is missing before this");
    return (of) => truth(whole(of));
  };
  /** Whether a text is words alone, none of which is a column or belongs to an expression. */
  const isWords = (text, known) => {
    const words = text.split(/[\s,]+/).filter(Boolean);
    return !/[<>=()[\]"'~!*%]/.test(text) && !words.some((word) => KEYWORDS.has(word) || known(word));
  };
  return { compile, isWords };
})();
