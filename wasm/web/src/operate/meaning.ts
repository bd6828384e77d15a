// What a parameter's description says of its values.

/** Returns the names of numbered values, from a description that lists them: "0 none, 1 running, 2 done".
 * Empty without such a list. */
export function valueNames(description: string): ReadonlyMap<number, string> {
    const names = new Map<number, string>();
    for (const [, number, name] of description.matchAll(/(?:^|[:,;.] )(\d+) ([a-z][^,:;.]*)/g)) {
        // A list counts upward; other numbers of the text do not continue it.
        if (Number(number) === names.size) {
            names.set(names.size, name.trim());
        }
    }
    return names.size > 1 ? names : new Map();
}
