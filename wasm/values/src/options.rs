//! Option objects: named arguments as JavaScript has them.

use crate::error::{list, shown, type_error};
use js_sys::{Object, Reflect};
use wasm_bindgen::{JsCast, JsValue};

/// An object of named arguments. Every name that is read must be one of those it was opened with.
pub struct Options {
    owner: &'static str,
    object: Object,
}

impl Options {
    /// Takes `value` for the options of `owner`, who knows these names only. Nothing given is no options.
    ///
    /// # Errors
    /// No object, or a name that `owner` does not know; the other calls likewise throw for a value that cannot be.
    pub fn new(owner: &'static str, value: &JsValue, names: &[&str]) -> Result<Self, JsValue> {
        if value.is_undefined() {
            return Ok(Self { owner, object: Object::new() });
        }
        if !value.is_object() {
            return Err(type_error(&format!("{owner}: options must be an object, not {}", shown(value))));
        }
        let object: Object = value.clone().unchecked_into();
        for key in Object::keys(&object).iter() {
            let key = key.as_string().unwrap_or_default();
            if !names.contains(&key.as_str()) {
                let known = list(names.iter().copied());
                return Err(type_error(&format!("{owner}: no option {key}; one of {known}")));
            }
        }
        Ok(Self { owner, object })
    }

    /// The value of `name`, or `None` where there is none.
    pub fn value(&self, name: &str) -> Result<Option<JsValue>, JsValue> {
        let value = Reflect::get(&self.object, &name.into())?;
        Ok((!value.is_undefined()).then_some(value))
    }

    /// A finite number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, JsValue> {
        let Some(value) = self.value(name)? else { return Ok(None) };
        match value.as_f64().filter(|number| number.is_finite()) {
            Some(number) => Ok(Some(number)),
            None => Err(self.refusal(name, &value, "a finite number")),
        }
    }

    /// A finite number that must be there.
    pub fn required(&self, name: &str) -> Result<f64, JsValue> {
        let missing = || type_error(&format!("{}: {name} is missing", self.owner));
        self.number(name)?.ok_or_else(missing)
    }

    /// A finite number, 0 or more.
    pub fn magnitude(&self, name: &str) -> Result<Option<f64>, JsValue> {
        match self.number(name)? {
            Some(number) if number < 0.0 => Err(self.out_of_range(name, number, "0 or more")),
            number => Ok(number),
        }
    }

    /// A whole number within `min..=max`.
    pub fn whole(&self, name: &str, min: f64, max: f64) -> Result<Option<f64>, JsValue> {
        match self.number(name)? {
            Some(number) if number.fract() != 0.0 || !(min..=max).contains(&number) => {
                let bound = |limit: f64| shown(&limit.into());
                let allowed = format!("a whole number from {} to {}", bound(min), bound(max));
                Err(self.out_of_range(name, number, &allowed))
            }
            number => Ok(number),
        }
    }

    /// True or false.
    pub fn flag(&self, name: &str) -> Result<Option<bool>, JsValue> {
        let Some(value) = self.value(name)? else { return Ok(None) };
        value.as_bool().map(Some).ok_or_else(|| self.refusal(name, &value, "true or false"))
    }

    /// One of the named values.
    pub fn choice<T: Copy>(&self, name: &str, choices: &[(&str, T)]) -> Result<Option<T>, JsValue> {
        let Some(value) = self.value(name)? else { return Ok(None) };
        let text = value.as_string();
        let found = choices.iter().find(|(choice, _)| text.as_deref() == Some(choice));
        let allowed = || format!("one of {}", list(choices.iter().map(|(choice, _)| *choice)));
        found.map(|(_, chosen)| Some(*chosen)).ok_or_else(|| self.refusal(name, &value, &allowed()))
    }

    fn refusal(&self, name: &str, value: &JsValue, allowed: &str) -> JsValue {
        type_error(&format!("{}: {name} {}: must be {allowed}", self.owner, shown(value)))
    }

    fn out_of_range(&self, name: &str, value: f64, allowed: &str) -> JsValue {
        crate::error::range_error(&format!(
            "{}: {name} {}: must be {allowed}",
            self.owner,
            shown(&value.into())
        ))
    }
}

/// Sets a property of a plain object that we made.
pub fn set(object: &Object, name: &str, value: impl Into<JsValue>) {
    // Only a frozen object refuses.
    let _ = Reflect::set(object, &name.into(), &value.into());
}
