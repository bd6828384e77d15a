// The update of the drive. It continues when another panel is opened.

import type { MasterError, UpdateProgress } from "narx/core";
import { session, words } from "./session.svelte";

/** Consequence of an error for the drive, by the error's name. */
const MEANING: Partial<Record<string, string>> = {
    ImageError: "The drive was not touched.",
    RefusedError: "The drive runs what it ran before.",
    NoAnswerError: "A drive that was reached runs what it ran before, if it comes back without being confirmed.",
} satisfies Partial<Record<MasterError["name"], string>>;

class Update {
    progress = $state.raw<UpdateProgress>();
    busy = $state(false);
    told = $state.raw<{ text: string; good: boolean }>();

    /** Programs the drive with an image; `told` is the result. */
    async run(image: Uint8Array, version: string): Promise<void> {
        this.busy = true;
        this.told = undefined;
        try {
            await session.run((drive) => drive.update(image, (progress) => (this.progress = progress)));
            this.told = { text: `The drive runs version ${version} now and keeps it.`, good: true };
        } catch (error) {
            const meaning = (error instanceof Error && MEANING[error.name]) || MEANING.NoAnswerError;
            this.told = { text: `${words(error)} ${meaning}`, good: false };
        }
        this.busy = false;
        this.progress = undefined;
    }

    abort(): void {
        session.drive?.master.abortUpdate();
        session.pump();
    }
}

export const update = new Update();
