// A room to begin with.

import { FIRST_CROWD } from "./forms";
import { t } from "./language";
import { Button } from "./parts";
import { change } from "./plan";
import { rectangle } from "./roomshape";
import { open } from "./scenes";

/** A room of 10 m × 8 m without doors; a scene has at least one person. */
export function NewRoom() {
    const begin = () => {
        const crowd = { ...FIRST_CROWD, number: 1, room: { outline: rectangle(10, 8), obstacles: [], doors: [] } };
        open("A new room", { base: { kind: "crowd", ...crowd }, edits: [], motion: { kind: "none" } }, false, crowd);
        change({ tab: "room" });
    };
    return (
        <Button words={t("New empty room")} title={t("10 m × 8 m, with one person: draw the room, then say in the tab Crowd how many are in it")} onClick={begin} />
    );
}
