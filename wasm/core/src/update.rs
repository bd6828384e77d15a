//! Programming the drive: an image on its way to the bootloader.

use crate::master::Master;
use crate::requests::{NO_ANSWER, REFUSED, thrown};
use js_sys::Object;
use narx_boot::Header;
use narx_boot::hardware::BOARDS;
use narx_core::master::{Image, UpdateError, UpdateProgress};
use narx_wasm_values::options::set;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Header of an image. */
export interface ImageInfo {
    /** Hardware id. */
    readonly hardware: number;
    /** Name of the board with this id; absent for one that this version does not know. */
    readonly board?: string;
    /** Version, MAJOR.MINOR.PATCH+BUILD. */
    readonly version: string;
    /** Length, bytes. */
    readonly length: number;
}

/** Progress of an update. */
export interface UpdateProgress {
    readonly stage: UpdateStage;
    /** Number of bytes that are done in this stage: erased, received or verified. */
    readonly done: number;
    /** Length of the image, bytes. */
    readonly total: number;
}
"#;

const IMAGE: &str = "ImageError";

#[wasm_bindgen]
impl Master {
    /// Begins to program the drive with an image, the bytes of a `.narximg` file. `poll` then also returns
    /// blocks of the image. Throws a `MasterError` for an incomplete image, for a silent master, and during
    /// another update.
    pub fn update(&mut self, image: Vec<u8>) -> Result<(), JsValue> {
        let Header { hardware, version, .. } = header(&image)?;
        let about = Image::new(hardware, version.into(), &image);
        self.core.update(about).map_err(|refused| thrown(REFUSED, &refused))?;
        self.image = image;
        Ok(())
    }

    /// Progress of the update; `undefined` without one.
    #[wasm_bindgen(getter, js_name = updateProgress, unchecked_return_type = "UpdateProgress | undefined")]
    pub fn update_progress(&self) -> JsValue {
        let Some(UpdateProgress { stage, done, total }) = self.core.update_progress() else {
            return JsValue::UNDEFINED;
        };
        let shaped = Object::new();
        set(&shaped, "stage", stage.label());
        set(&shaped, "done", done);
        set(&shaped, "total", total);
        shaped.into()
    }

    /// Returns whether the update has succeeded: the drive runs the image now and keeps it. Throws a
    /// `MasterError` for one that failed; the previous image then still runs.
    #[wasm_bindgen(js_name = pollUpdate)]
    pub fn poll_update(&mut self) -> Result<bool, JsValue> {
        self.core.poll_update().transpose().map(|end| end.is_some()).map_err(update_error)
    }

    /// Aborts the update. An image that is swapped in already is not confirmed, so the drive goes back to the
    /// previous one.
    #[wasm_bindgen(js_name = abortUpdate)]
    pub fn abort_update(&mut self) {
        self.core.abort_update();
    }
}

/// Returns the header of an image (the bytes of a `.narximg` file). Throws a `MasterError` for an incomplete
/// image.
#[wasm_bindgen(js_name = imageInfo, unchecked_return_type = "ImageInfo")]
pub fn image_info(image: &[u8]) -> Result<Object, JsValue> {
    let header = header(image)?;
    let shaped = Object::new();
    set(&shaped, "hardware", header.hardware);
    if let Some((board, _)) = BOARDS.iter().find(|(_, hardware)| *hardware == header.hardware) {
        set(&shaped, "board", *board);
    }
    set(&shaped, "version", header.version.to_string());
    set(&shaped, "length", header.image_length());
    Ok(shaped)
}

fn header(image: &[u8]) -> Result<Header, JsValue> {
    Header::of(image).map_err(|refused| thrown(IMAGE, &refused))
}

fn update_error(error: UpdateError) -> JsValue {
    let name = match error {
        UpdateError::NoAnswer | UpdateError::Silent => NO_ANSWER,
        UpdateError::Hardware { .. } | UpdateError::TooLong { .. } | UpdateError::Older { .. } => IMAGE,
        _ => REFUSED,
    };
    thrown(name, &error)
}
