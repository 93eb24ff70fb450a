//! Values of columns: their types, and how the values of a Rust type become a column.

use std::sync::Arc;

/// The type of a column's values. No value is ever missing: a column says which value stands for "none".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// 8-bit unsigned.
    U8,
    /// 8-bit signed.
    I8,
    /// 16-bit unsigned.
    U16,
    /// 32-bit unsigned.
    U32,
    /// 32-bit signed.
    I32,
    /// 64-bit unsigned.
    U64,
    /// 64-bit signed.
    I64,
    /// 32-bit float.
    F32,
    /// True or false.
    Bool,
    /// A word out of a list that is known before the first row.
    Word,
}

impl Type {
    /// Its name, as documents and pages have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F32 => "f32",
            Self::Bool => "bool",
            Self::Word => "word",
        }
    }
}

/// The words of a column.
#[derive(Clone, Debug)]
pub enum Names {
    /// The same in every trace.
    Fixed(&'static [&'static str]),
    /// Those of a trace or a machine.
    Shared(Arc<[String]>),
}

impl Default for Names {
    fn default() -> Self {
        Self::Fixed(&[])
    }
}

impl Names {
    /// Names that are only known when the program runs.
    pub fn shared(names: impl IntoIterator<Item = String>) -> Self {
        Self::Shared(names.into_iter().collect())
    }

    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::Fixed(names) => names.len(),
            Self::Shared(names) => names.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The word of a code; empty for a code that has none.
    pub fn get(&self, code: u32) -> &str {
        match self {
            Self::Fixed(names) => names.get(code as usize).copied().unwrap_or_default(),
            Self::Shared(names) => names.get(code as usize).map_or("", String::as_str),
        }
    }

    /// All of them, by code.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        (0..self.len() as u32).map(|code| self.get(code))
    }

    /// Bytes of the longest.
    pub fn longest(&self) -> usize {
        self.iter().map(str::len).max().unwrap_or(0)
    }
}

/// Words by code, with the list that they are out of.
#[derive(Clone, Debug, Default)]
pub struct Words {
    /// One a row.
    pub codes: Vec<u32>,
    /// What the codes mean.
    pub names: Names,
}

/// The values of a column in a batch.
#[derive(Clone, Debug)]
pub enum Column {
    /// 8-bit unsigned.
    U8(Vec<u8>),
    /// 8-bit signed.
    I8(Vec<i8>),
    /// 16-bit unsigned.
    U16(Vec<u16>),
    /// 32-bit unsigned.
    U32(Vec<u32>),
    /// 32-bit signed.
    I32(Vec<i32>),
    /// 64-bit unsigned.
    U64(Vec<u64>),
    /// 64-bit signed.
    I64(Vec<i64>),
    /// 32-bit floats.
    F32(Vec<f32>),
    /// True or false.
    Bool(Vec<bool>),
    /// Words.
    Word(Words),
}

/// Calls `$what` with the values of a column, whatever their type; words by their codes.
macro_rules! each {
    ($column:expr, $values:ident => $what:expr) => {
        match $column {
            $crate::value::Column::U8($values) => $what,
            $crate::value::Column::I8($values) => $what,
            $crate::value::Column::U16($values) => $what,
            $crate::value::Column::U32($values) => $what,
            $crate::value::Column::I32($values) => $what,
            $crate::value::Column::U64($values) => $what,
            $crate::value::Column::I64($values) => $what,
            $crate::value::Column::F32($values) => $what,
            $crate::value::Column::Bool($values) => $what,
            $crate::value::Column::Word($crate::value::Words { codes: $values, .. }) => $what,
        }
    };
}

impl Column {
    /// How many rows.
    pub fn len(&self) -> usize {
        each!(self, values => values.len())
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The words, of a column of words.
    pub fn names(&self) -> Option<&Names> {
        match self {
            Self::Word(words) => Some(&words.names),
            _ => None,
        }
    }

    /// Takes the rows from `at` on away, and gives them.
    #[must_use]
    pub fn split_off(&mut self, at: usize) -> Self {
        match self {
            Self::U8(values) => Self::U8(values.split_off(at)),
            Self::I8(values) => Self::I8(values.split_off(at)),
            Self::U16(values) => Self::U16(values.split_off(at)),
            Self::U32(values) => Self::U32(values.split_off(at)),
            Self::I32(values) => Self::I32(values.split_off(at)),
            Self::U64(values) => Self::U64(values.split_off(at)),
            Self::I64(values) => Self::I64(values.split_off(at)),
            Self::F32(values) => Self::F32(values.split_off(at)),
            Self::Bool(values) => Self::Bool(values.split_off(at)),
            Self::Word(Words { codes, names }) => {
                Self::Word(Words { codes: codes.split_off(at), names: names.clone() })
            }
        }
    }

    /// Gives back memory that no row takes.
    pub fn shrink(&mut self) {
        each!(self, values => values.shrink_to_fit());
    }

    /// Appends the rows of a column of the same type; those of another type are left out.
    pub fn extend(&mut self, more: Self) {
        match (self, more) {
            (Self::U8(to), Self::U8(from)) => to.extend(from),
            (Self::I8(to), Self::I8(from)) => to.extend(from),
            (Self::U16(to), Self::U16(from)) => to.extend(from),
            (Self::U32(to), Self::U32(from)) => to.extend(from),
            (Self::I32(to), Self::I32(from)) => to.extend(from),
            (Self::U64(to), Self::U64(from)) => to.extend(from),
            (Self::I64(to), Self::I64(from)) => to.extend(from),
            (Self::F32(to), Self::F32(from)) => to.extend(from),
            (Self::Bool(to), Self::Bool(from)) => to.extend(from),
            (Self::Word(to), Self::Word(from)) => to.codes.extend(from.codes),
            _ => {}
        }
    }
}

/// What holds the values of a column while rows are made.
pub trait Values: Default {
    /// Its type.
    const TYPE: Type;

    /// The column.
    fn column(self) -> Column;
}

macro_rules! values {
    ($($rust:ty => $kind:ident;)*) => {$(
        impl Values for Vec<$rust> {
            const TYPE: Type = Type::$kind;

            fn column(self) -> Column {
                Column::$kind(self)
            }
        }
    )*};
}

values! {
    u8 => U8;
    i8 => I8;
    u16 => U16;
    u32 => U32;
    i32 => I32;
    u64 => U64;
    i64 => I64;
    f32 => F32;
    bool => Bool;
}

impl Values for Words {
    const TYPE: Type = Type::Word;

    fn column(self) -> Column {
        Column::Word(self)
    }
}

/// A word out of a list that is the same in every trace.
pub trait Word: Copy {
    /// The list.
    const NAMES: &'static [&'static str];

    /// Its place there.
    fn code(self) -> u32;
}

/// Declares an enum of words.
macro_rules! word {
    ($(#[$doc:meta])* pub enum $name:ident { $($(#[$why:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name { $($(#[$why])* $variant,)* }

        impl $crate::value::Word for $name {
            const NAMES: &'static [&'static str] = &[$($text,)*];

            fn code(self) -> u32 {
                self as u32
            }
        }
    };
}
pub(crate) use word;

/// Words of one list while rows are made.
#[derive(Clone, Debug)]
pub struct WordsOf<W> {
    codes: Vec<u32>,
    list: std::marker::PhantomData<W>,
}

impl<W> Default for WordsOf<W> {
    fn default() -> Self {
        Self { codes: Vec::new(), list: std::marker::PhantomData }
    }
}

impl<W: Word> WordsOf<W> {
    /// Appends a word.
    #[inline]
    pub fn push(&mut self, word: W) {
        self.codes.push(word.code());
    }
}

impl<W: Word> Values for WordsOf<W> {
    const TYPE: Type = Type::Word;

    fn column(self) -> Column {
        Column::Word(Words { codes: self.codes, names: Names::Fixed(W::NAMES) })
    }
}
