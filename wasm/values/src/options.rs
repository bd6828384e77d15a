//! Option objects: the named arguments of JavaScript.

use crate::error::{list, range_error, shown, type_error, whole};
use js_sys::{Object, Reflect};
use wasm_bindgen::{JsCast, JsValue};

/// An object of named arguments. Read only names that were passed to `new`.
pub struct Options {
    owner: &'static str,
    object: Object,
}

impl Options {
    /// Takes `value` as the options of `owner`, which has only these names; `undefined` counts as an empty
    /// object.
    ///
    /// # Errors
    /// Not an object, or a name that `owner` does not have; the other functions likewise return an error for
    /// an invalid value.
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

    /// Returns the value of `name`, or `None` if it is missing.
    pub fn value(&self, name: &str) -> Result<Option<JsValue>, JsValue> {
        let value = Reflect::get(&self.object, &name.into())?;
        Ok((!value.is_undefined()).then_some(value))
    }

    /// Returns a finite number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, JsValue> {
        let Some(value) = self.value(name)? else { return Ok(None) };
        match value.as_f64().filter(|number| number.is_finite()) {
            Some(number) => Ok(Some(number)),
            None => Err(self.refusal(name, &value, "a finite number")),
        }
    }

    /// Returns a finite number, which must be given.
    pub fn required(&self, name: &str) -> Result<f64, JsValue> {
        self.number(name)?.ok_or_else(|| self.missing(name))
    }

    /// Returns the error for an option that must be given and is missing.
    pub fn missing(&self, name: &str) -> JsValue {
        type_error(&format!("{}: {name} is missing", self.owner))
    }

    /// Returns a finite number, 0 or more.
    pub fn magnitude(&self, name: &str) -> Result<Option<f64>, JsValue> {
        match self.number(name)? {
            Some(number) if number < 0.0 => {
                let (owner, number) = (self.owner, shown(&number.into()));
                Err(range_error(&format!("{owner}: {name} {number}: must be 0 or more")))
            }
            number => Ok(number),
        }
    }

    /// Returns a whole number within `min..=max`.
    pub fn whole(&self, name: &str, min: f64, max: f64) -> Result<Option<f64>, JsValue> {
        let Some(number) = self.number(name)? else { return Ok(None) };
        whole(&format!("{}: {name}", self.owner), number, min, max).map(Some)
    }

    /// Returns true or false.
    pub fn flag(&self, name: &str) -> Result<Option<bool>, JsValue> {
        let Some(value) = self.value(name)? else { return Ok(None) };
        value.as_bool().map(Some).ok_or_else(|| self.refusal(name, &value, "true or false"))
    }

    /// Returns the value of `choices` with the given name.
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
}

/// Sets a property of a plain object that this package has made.
pub fn set(object: &Object, name: &str, value: impl Into<JsValue>) {
    // It fails only for a frozen object.
    let _ = Reflect::set(object, &name.into(), &value.into());
}
