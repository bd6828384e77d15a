// The file of a new program, chosen on its panel or dropped anywhere on the page.

/** How such a file is called. */
export const SUFFIX = ".narximg";

export const image = $state<{ file?: File }>({});
