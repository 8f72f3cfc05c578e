//! The other direction of [`words`](crate::words): what a launch is given.

use crate::words::Mismatch;
use serde::ser::{self, Serialize};
use std::fmt::Display;
use std::vec::Vec;

impl ser::Error for Mismatch {
    fn custom<T: Display>(_: T) -> Self {
        Self
    }
}

/// A structure of numbers and choices in [words](crate::words).
///
/// # Errors
/// It holds something else, such as text.
pub fn written(value: &impl Serialize) -> Result<Vec<u32>, Mismatch> {
    let mut words = Vec::new();
    value.serialize(&mut Writer(&mut words))?;
    Ok(words)
}

struct Writer<'a>(&'a mut Vec<u32>);

impl Writer<'_> {
    fn push(&mut self, word: u32) -> Result<(), Mismatch> {
        self.0.push(word);
        Ok(())
    }
}

macro_rules! never {
    ($($method:ident($type:ty))+) => {$(
        fn $method(self, _: $type) -> Result<(), Mismatch> {
            Err(Mismatch)
        }
    )+};
}

impl ser::Serializer for &mut Writer<'_> {
    type Ok = ();
    type Error = Mismatch;
    type SerializeSeq = ser::Impossible<(), Mismatch>;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Self;
    type SerializeMap = ser::Impossible<(), Mismatch>;
    type SerializeStruct = Self;
    type SerializeStructVariant = Self;

    never! {
        serialize_i8(i8) serialize_i16(i16) serialize_i64(i64) serialize_u8(u8) serialize_u16(u16)
        serialize_u64(u64) serialize_char(char) serialize_str(&str) serialize_bytes(&[u8])
    }

    fn serialize_bool(self, value: bool) -> Result<(), Mismatch> {
        self.push(u32::from(value))
    }

    fn serialize_u32(self, value: u32) -> Result<(), Mismatch> {
        self.push(value)
    }

    fn serialize_i32(self, value: i32) -> Result<(), Mismatch> {
        self.push(value.cast_unsigned())
    }

    fn serialize_f32(self, value: f32) -> Result<(), Mismatch> {
        self.push(value.to_bits())
    }

    fn serialize_f64(self, value: f64) -> Result<(), Mismatch> {
        let bits = value.to_bits();
        let half = |bits: u64| u32::try_from(bits & u64::from(u32::MAX)).unwrap_or_default();
        self.push(half(bits))?;
        self.push(half(bits >> 32))
    }

    fn serialize_none(self) -> Result<(), Mismatch> {
        self.push(0)
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Mismatch> {
        self.push(1)?;
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), Mismatch> {
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Result<(), Mismatch> {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, kind: u32, _: &'static str) -> Result<(), Mismatch> {
        self.push(kind)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Mismatch> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        kind: u32,
        _: &'static str,
        value: &T,
    ) -> Result<(), Mismatch> {
        self.push(kind)?;
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Self::SerializeSeq, Mismatch> {
        Err(Mismatch)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, Mismatch> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, Mismatch> {
        Ok(self)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        kind: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, Mismatch> {
        self.push(kind)?;
        Ok(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, Mismatch> {
        Err(Mismatch)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, Mismatch> {
        Ok(self)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        kind: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, Mismatch> {
        self.push(kind)?;
        Ok(self)
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

macro_rules! parts {
    ($($of:ident $method:ident($($name:ident: $type:ty),*);)+) => {$(
        impl ser::$of for &mut Writer<'_> {
            type Ok = ();
            type Error = Mismatch;

            fn $method<T: Serialize + ?Sized>(
                &mut self,
                $($name: $type,)*
                value: &T,
            ) -> Result<(), Mismatch> {
                value.serialize(&mut **self)
            }

            fn end(self) -> Result<(), Mismatch> {
                Ok(())
            }
        }
    )+};
}

parts! {
    SerializeTuple serialize_element();
    SerializeTupleStruct serialize_field();
    SerializeTupleVariant serialize_field();
    SerializeStruct serialize_field(_name: &'static str);
    SerializeStructVariant serialize_field(_name: &'static str);
}
