//! C99 initialisers of coefficients: a desk computes them, and a C program has them as a constant.

use crate::motor::Coefficients;
use crate::motor::drive::BEHAVIOUR_VERSION;
use core::fmt::{self, Display, Write};
use serde::ser::{self, Impossible, Serialize, Serializer};

/// Writes a header with the coefficients of a motor's control, for `narx_motor_init`.
///
/// # Errors
/// Fails if `to` does.
pub fn header(to: &mut dyn Write, name: &str, coefficients: &Coefficients) -> fmt::Result {
    write!(
        to,
        "/* Coefficients of a motor's control, computed by narx {}. Make them again, do not edit them. */

#include \"narx.h\"

#if NARX_COEFFICIENTS_VERSION != {BEHAVIOUR_VERSION}
#error \"these coefficients were made for another version of narx: make them again\"
#endif

",
        env!("CARGO_PKG_VERSION")
    )?;
    define(to, "narx_coefficients_t", name, coefficients)
}

/// Writes the definition of a constant: `static const TYPE NAME = {...};`.
///
/// # Errors
/// Fails if `to` does, and for a value that has no initialiser in C: only numbers, flags, structures and
/// arrays have one.
pub fn define(to: &mut dyn Write, c_type: &str, name: &str, value: &impl Serialize) -> fmt::Result {
    write!(to, "static const {c_type} {name} = ")?;
    value.serialize(Initialiser { to, depth: 0 }).map_err(|Failed| fmt::Error)?;
    to.write_str(";\n")
}

/// Reports whether a name is an identifier of C.
pub fn is_identifier(name: &str) -> bool {
    let mut letters = name.bytes();
    letters.next().is_some_and(|first| first.is_ascii_alphabetic() || first == b'_')
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == b'_')
}

struct Initialiser<'a> {
    to: &'a mut dyn Write,
    depth: usize,
}

#[derive(Debug)]
struct Failed;

impl Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no initialiser in C")
    }
}

impl core::error::Error for Failed {}

impl ser::Error for Failed {
    fn custom<T: Display>(_: T) -> Self {
        Self
    }
}

impl From<fmt::Error> for Failed {
    fn from(_: fmt::Error) -> Self {
        Self
    }
}

/// A structure or an array, element by element.
struct Elements<'a> {
    to: &'a mut dyn Write,
    depth: usize,
    is_first: bool,
}

impl<'a> Elements<'a> {
    fn begin(Initialiser { to, depth }: Initialiser<'a>) -> Result<Self, Failed> {
        to.write_str("{")?;
        Ok(Self { to, depth: depth + 1, is_first: true })
    }

    fn element(&mut self, value: &(impl Serialize + ?Sized)) -> Result<(), Failed> {
        if !core::mem::take(&mut self.is_first) {
            self.to.write_str(", ")?;
        }
        value.serialize(Initialiser { to: &mut *self.to, depth: self.depth })
    }

    fn line(&mut self, depth: usize) -> fmt::Result {
        write!(self.to, "\n{:1$}", "", 4 * depth)
    }
}

impl ser::SerializeStruct for Elements<'_> {
    type Ok = ();
    type Error = Failed;

    fn serialize_field<T: Serialize + ?Sized>(
        &mut self,
        name: &'static str,
        value: &T,
    ) -> Result<(), Failed> {
        self.line(self.depth)?;
        write!(self.to, ".{name} = ")?;
        value.serialize(Initialiser { to: &mut *self.to, depth: self.depth })?;
        Ok(self.to.write_str(",")?)
    }

    fn end(mut self) -> Result<(), Failed> {
        self.line(self.depth - 1)?;
        Ok(self.to.write_str("}")?)
    }
}

impl ser::SerializeTuple for Elements<'_> {
    type Ok = ();
    type Error = Failed;

    fn serialize_element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Failed> {
        self.element(value)
    }

    fn end(self) -> Result<(), Failed> {
        Ok(self.to.write_str("}")?)
    }
}

/// Numbers, as C writes them.
macro_rules! numbers {
    ($($method:ident: $kind:ty),*) => {
        $(fn $method(self, value: $kind) -> Result<(), Failed> {
            Ok(write!(self.to, "{value}")?)
        })*
    };
}

/// Kinds of values that coefficients do not contain.
macro_rules! refused {
    ($($method:ident($($kind:ty),*) -> $answer:ty;)*) => {
        $(fn $method(self, $(_: $kind),*) -> Result<$answer, Failed> {
            Err(Failed)
        })*
    };
}

impl<'a> Serializer for Initialiser<'a> {
    type Ok = ();
    type Error = Failed;
    type SerializeSeq = Impossible<(), Failed>;
    type SerializeTuple = Elements<'a>;
    type SerializeTupleStruct = Impossible<(), Failed>;
    type SerializeTupleVariant = Impossible<(), Failed>;
    type SerializeMap = Impossible<(), Failed>;
    type SerializeStruct = Elements<'a>;
    type SerializeStructVariant = Impossible<(), Failed>;

    numbers! {
        serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64
    }

    refused! {
        serialize_f32(f32) -> ();
        serialize_f64(f64) -> ();
        serialize_char(char) -> ();
        serialize_str(&str) -> ();
        serialize_bytes(&[u8]) -> ();
        serialize_none() -> ();
        serialize_unit() -> ();
        serialize_unit_struct(&'static str) -> ();
        serialize_unit_variant(&'static str, u32, &'static str) -> ();
        serialize_seq(Option<usize>) -> Self::SerializeSeq;
        serialize_tuple_struct(&'static str, usize) -> Self::SerializeTupleStruct;
        serialize_tuple_variant(&'static str, u32, &'static str, usize) -> Self::SerializeTupleVariant;
        serialize_map(Option<usize>) -> Self::SerializeMap;
        serialize_struct_variant(&'static str, u32, &'static str, usize) -> Self::SerializeStructVariant;
    }

    fn serialize_some<T: Serialize + ?Sized>(self, _: &T) -> Result<(), Failed> {
        Err(Failed)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Failed> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: &T,
    ) -> Result<(), Failed> {
        Err(Failed)
    }

    fn serialize_tuple(self, _: usize) -> Result<Elements<'a>, Failed> {
        Elements::begin(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Elements<'a>, Failed> {
        Elements::begin(self)
    }

    fn collect_str<T: Display + ?Sized>(self, _: &T) -> Result<(), Failed> {
        Err(Failed)
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}
