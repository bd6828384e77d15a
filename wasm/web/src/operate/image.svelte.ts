// The file of a new program, chosen on its panel or dropped anywhere on the page.

/** Suffix of an image file. */
export const SUFFIX = ".narximg";

export const image = $state<{ file?: File }>({});
