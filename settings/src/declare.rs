//! The macros that declare settings: each field once, with rule, meaning and unit.

/// Declares structs of settings: fields for serde, and the table of their keys ([`Settings`](crate::Settings)).
///
/// A field is `name: type = rule, "meaning", "unit";`, the unit left out for words, flags and pure numbers. A field without a rule
/// is a table, of a type that is itself declared so; `name: type as other, ..` takes the keys of another type. A last field `..name: type, "meaning";` puts the fields of its type among
/// those of the struct. Meaning and unit become the documentation; a comment on a field adds to it. The calling crate needs serde.
#[macro_export]
macro_rules! settings {
    ($(
        $(#[$meta:meta])*
        $vis:vis struct $name:ident {
            $($(#[$more:meta])* $field:ident: $type:ty $(as $keys:ty)? $(= $rule:expr)?, $text:literal $(, $unit:literal)?;)*
            $(..$rest:ident: $rest_type:ty, $rest_text:literal;)?
        }
    )+) => {$(
        #[derive(Clone, Debug, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        $(#[$meta])*
        $vis struct $name {
            $(#[doc = concat!($text $(, " (", $unit, ")")?, ".")] $(#[$more])* pub $field: $type,)*
            $(#[doc = concat!($rest_text, ".")] #[serde(flatten)] pub $rest: $rest_type,)?
        }

        impl $crate::Settings for $name {
            const ENTRIES: &'static [$crate::Entry] = &[
                $($crate::entry!($field, $type, $text $(, keys $keys)? $(, unit $unit)? $(, rule $rule)?),)*
                $($crate::Entry::Flat(<$rest_type as $crate::Settings>::ENTRIES),)?
            ];
        }
    )+};
}

/// The [`Entry`](crate::Entry) of a field of [`settings!`](crate::settings).
#[doc(hidden)]
#[macro_export]
macro_rules! entry {
    ($field:ident, $type:ty, $text:literal) => {
        $crate::Entry::Table(stringify!($field), <$type as $crate::Settings>::ENTRIES)
    };
    ($field:ident, $type:ty, $text:literal, keys $keys:ty) => {
        $crate::entry!($field, $keys, $text)
    };
    ($field:ident, $type:ty, $text:literal, rule $rule:expr) => {
        $crate::entry!($field, $type, $text, unit "", rule $rule)
    };
    ($field:ident, $type:ty, $text:literal, unit $unit:literal, rule $rule:expr) => {
        $crate::Entry::Key($crate::Key { name: stringify!($field), rule: $rule, unit: $unit, meaning: $text })
    };
}

/// Declares enums of which a setting takes one word: variants for code, words for files. The calling crate needs serde.
#[macro_export]
macro_rules! words {
    ($(
        $(#[$meta:meta])*
        $vis:vis enum $name:ident { $($(#[$doc:meta])* $variant:ident = $word:literal,)+ }
    )+) => {$(
        #[derive(Clone, Copy, Debug, PartialEq, Eq, ::serde::Serialize, ::serde::Deserialize)]
        $(#[$meta])*
        $vis enum $name { $($(#[$doc])* #[serde(rename = $word)] $variant,)+ }

        impl $name {
            /// All of them, in order.
            $vis const ALL: &'static [Self] = &[$(Self::$variant),+];
            /// What files may write.
            $vis const RULE: $crate::Rule = $crate::Rule::Word(&[$($word),+]);

            /// The word in files.
            $vis const fn name(self) -> &'static str {
                match self { $(Self::$variant => $word),+ }
            }

            /// The one of this word.
            $vis fn parse(word: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|known| known.name() == word)
            }
        }
    )+};
}

#[cfg(test)]
mod tests {
    use crate::key::flatten;
    use crate::{Rule, Settings};

    words! {
        /// A colour.
        enum Colour {
            /// Like a rose.
            DeepRed = "deep_red",
            /// Like the sea.
            Blue = "blue",
        }
    }

    settings! {
        /// Outer.
        struct Outer {
            /// More about it.
            width: u32 = Rule::Integer(1, 9), "how wide", "metres";
            inner: Inner, "what is inside";
            ..rest: Rest, "the rest";
        }

        /// Inner.
        struct Inner {
            colour: Colour = Colour::RULE, "which colour";
        }

        /// Rest.
        struct Rest {
            lit: bool = Rule::Flag, "whether it glows";
        }
    }

    #[test]
    fn a_struct_and_its_keys_are_declared_together() {
        let mut keys = Vec::new();
        flatten(Outer::ENTRIES, "", &mut keys);
        let all: Vec<_> = keys.iter().map(|k| (k.name, k.rule, k.about())).collect();
        assert_eq!(
            all,
            [
                ("width", Rule::Integer(1, 9), "how wide, metres".to_owned()),
                ("inner.colour", Rule::Word(&["deep_red", "blue"]), "which colour".to_owned()),
                ("lit", Rule::Flag, "whether it glows".to_owned()),
            ]
        );
        let outer: Outer = toml::from_str("width = 3\nlit = true\ninner = { colour = \"deep_red\" }").unwrap();
        let same = Outer { width: 3, inner: Inner { colour: Colour::DeepRed }, rest: Rest { lit: true } };
        assert_eq!(outer, same);
        assert_eq!(toml::to_string(&same).unwrap(), "width = 3\nlit = true\n\n[inner]\ncolour = \"deep_red\"\n");
    }

    #[test]
    fn words_are_read_as_they_are_written() {
        assert_eq!(Colour::ALL.iter().map(|c| c.name()).collect::<Vec<_>>(), ["deep_red", "blue"]);
        assert_eq!((Colour::parse("blue"), Colour::parse("Blue")), (Some(Colour::Blue), None));
    }
}
