// Files for download, and files chosen by the user.

/** Offers a file for download. */
export function save(name: string, content: BlobPart, type = "application/octet-stream"): void {
    const url = URL.createObjectURL(new Blob([content], { type }));
    Object.assign(document.createElement("a"), { href: url, download: name }).click();
    // The browser reads the address only after the click's task.
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** Asks the user for one file; `undefined` if none was chosen. */
export function choose(accept: string): Promise<File | undefined> {
    const input = Object.assign(document.createElement("input"), { type: "file", accept });
    return new Promise((resolve) => {
        input.addEventListener("change", () => resolve(input.files?.[0]));
        input.addEventListener("cancel", () => resolve(undefined));
        input.click();
    });
}
