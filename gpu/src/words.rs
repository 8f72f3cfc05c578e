//! Any structure as 32-bit words and back, to the bit: how settings get into a GPU's memory.
//!
//! A number is its bits, a choice the index of its kind, what may be missing a 1 before it or a 0 alone. The
//! words say nothing of themselves: who reads them knows the type.

use core::fmt;
use serde::de::{self, Deserialize, DeserializeSeed, IntoDeserializer, Visitor};

/// They do not say what was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mismatch;

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("words of another structure")
    }
}

impl core::error::Error for Mismatch {}

impl de::Error for Mismatch {
    #[inline(always)]
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self
    }
    #[inline(always)]
    fn invalid_length(_: usize, _: &dyn de::Expected) -> Self {
        Self
    }
    #[inline(always)]
    fn invalid_value(_: de::Unexpected<'_>, _: &dyn de::Expected) -> Self {
        Self
    }
    #[inline(always)]
    fn invalid_type(_: de::Unexpected<'_>, _: &dyn de::Expected) -> Self {
        Self
    }
}

/// Reads what was written so, from its beginning.
///
/// # Errors
/// The words end too early or name a kind that there is not.
#[inline(always)]
pub fn read<'de, T: Deserialize<'de>>(words: &'de [u32]) -> Result<T, Mismatch> {
    T::deserialize(&mut Reader { words, next: 0 })
}

struct Reader<'de> {
    words: &'de [u32],
    next: usize,
}

impl Reader<'_> {
    #[inline(always)]
    fn word(&mut self) -> Result<u32, Mismatch> {
        let word = self.words.get(self.next).copied().ok_or(Mismatch)?;
        self.next += 1;
        Ok(word)
    }
}

macro_rules! numbers {
    ($($method:ident $visit:ident $of:expr;)+) => {$(
        #[inline(always)]
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mismatch> {
            let of: fn(u32) -> _ = $of;
            visitor.$visit(of(self.word()?))
        }
    )+};
}

macro_rules! sequences {
    ($($method:ident($($name:ident: $type:ty),*) $count:expr;)+) => {$(
        #[inline(always)]
        fn $method<V: Visitor<'de>>(self, $($name: $type,)* visitor: V) -> Result<V::Value, Mismatch> {
            let left = $count;
            visitor.visit_seq(Elements { reader: self, left })
        }
    )+};
}

macro_rules! never {
    ($($method:ident)+) => {$(
        #[inline(always)]
        fn $method<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Mismatch> {
            Err(Mismatch)
        }
    )+};
}

impl<'de> de::Deserializer<'de> for &mut Reader<'de> {
    type Error = Mismatch;

    numbers! {
        deserialize_bool visit_bool |word| word != 0;
        deserialize_u32 visit_u32 |word| word;
        deserialize_i32 visit_i32 u32::cast_signed;
        deserialize_f32 visit_f32 f32::from_bits;
    }

    sequences! {
        deserialize_tuple(length: usize) length;
        deserialize_tuple_struct(_name: &'static str, length: usize) length;
        deserialize_struct(_name: &'static str, fields: &'static [&'static str]) fields.len();
    }

    never! {
        deserialize_any deserialize_i8 deserialize_i16 deserialize_i64 deserialize_u8 deserialize_u16
        deserialize_u64 deserialize_char deserialize_str deserialize_string deserialize_bytes
        deserialize_byte_buf deserialize_unit deserialize_seq deserialize_map deserialize_identifier
        deserialize_ignored_any
    }

    #[inline(always)]
    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mismatch> {
        let (low, high) = (self.word()?, self.word()?);
        visitor.visit_f64(f64::from_bits(u64::from(high) << 32 | u64::from(low)))
    }

    #[inline(always)]
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mismatch> {
        if self.word()? == 0 { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    #[inline(always)]
    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        visitor.visit_unit()
    }

    #[inline(always)]
    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        visitor.visit_newtype_struct(self)
    }

    #[inline(always)]
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        visitor.visit_enum(self)
    }

    #[inline(always)]
    fn is_human_readable(&self) -> bool {
        false
    }
}

struct Elements<'a, 'de> {
    reader: &'a mut Reader<'de>,
    left: usize,
}

impl<'de> de::SeqAccess<'de> for Elements<'_, 'de> {
    type Error = Mismatch;

    #[inline(always)]
    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Mismatch> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        seed.deserialize(&mut *self.reader).map(Some)
    }
}

impl<'de> de::EnumAccess<'de> for &mut Reader<'de> {
    type Error = Mismatch;
    type Variant = Self;

    #[inline(always)]
    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self), Mismatch> {
        let kind = self.word()?;
        let kind: de::value::U32Deserializer<Mismatch> = kind.into_deserializer();
        Ok((seed.deserialize(kind)?, self))
    }
}

impl<'de> de::VariantAccess<'de> for &mut Reader<'de> {
    type Error = Mismatch;

    #[inline(always)]
    fn unit_variant(self) -> Result<(), Mismatch> {
        Ok(())
    }

    #[inline(always)]
    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Mismatch> {
        seed.deserialize(self)
    }

    #[inline(always)]
    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Mismatch> {
        visitor.visit_seq(Elements { reader: self, left: length })
    }

    #[inline(always)]
    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        visitor.visit_seq(Elements { reader: self, left: fields.len() })
    }
}
