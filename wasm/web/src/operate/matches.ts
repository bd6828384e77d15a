// Search by words.

/** Returns whether a text has every word of a search, in any order; case, hyphens and underscores do not
 * matter. */
export function matches(text: string, search: string): boolean {
    const folded = fold(text);
    return fold(search).trim().split(/\s+/).every((word) => folded.includes(word));
}

function fold(text: string): string {
    return text.toLowerCase().replaceAll(/[-_]/g, "");
}
