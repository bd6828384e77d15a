// The update of the drive. It continues when another panel is opened.

import type { MasterError, UpdateProgress } from "narx/core";
import { session, words } from "./session.svelte";

/** Consequence of an error for the drive, by the error's name. */
const MEANING: Partial<Record<string, string>> = {
    ImageError: "The drive was not changed.",
    RefusedError: "The drive runs its previous firmware.",
    NoAnswerError: "If the drive was reached and restarts without a confirmation, it runs its previous firmware.",
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
            this.told = { text: `The drive now runs version ${version}, and the update is confirmed.`, good: true };
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
