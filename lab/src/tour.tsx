// A tour of four steps, for those who are here for the first time.

import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "./language";
import { Button } from "./parts";
import { change } from "./plan";

const STEPS: [string, string, string][] = [
    [".frame", t("The stage"), t("Each person is a body of five disks, which push each other by springs and friction. Grey people bear less than 200 N; the scale below says what the other colours mean. The line at the top answers the question. Click a person for numbers; the wheel zooms.")],
    [".transport", t("The timeline"), t("Play, pause, or drag the time. Green marks are people who leave. The chart below has the same time: what the question asks, or what you choose.")],
    [".sliders", t("The question"), t("Move a slider, and the scene runs again with the new value. Keep a run to see both side by side. A sweep runs many values with many crowds and shows the spread.")],
    ["header nav", t("Your own"), t("Draw your room, place a crowd, say what moves it. Take away gives pictures, tables, a report, and files for other programs. All you change is saved in this browser.")],
];

const step = signal<number | null>(null);

export function TourButton() {
    const begin = () => {
        change({ tab: "start" });
        step.value = 0;
    };
    return <Button words={t("Tour in four steps")} onClick={begin} />;
}

export function Tour() {
    const k = step.value;
    useEffect(() => {
        if (k === null) return;
        const about = document.querySelector(STEPS[k]![0]);
        about?.classList.add("toured");
        return () => about?.classList.remove("toured");
    }, [k]);
    if (k === null) return null;
    const [, title, words] = STEPS[k]!;
    const last = k === STEPS.length - 1;
    return (
        <div class="tour" role="dialog" aria-label={t("Tour")} onKeyDown={(event) => event.key === "Escape" && (step.value = null)}>
            <h2>{t("{k} of {n}: {name}", { k: k + 1, n: STEPS.length, name: title })}</h2>
            <p>{words}</p>
            <div class="buttons">
                <button key={k} type="button" class="main" ref={(button) => button?.focus()} onClick={() => (step.value = last ? null : k + 1)}>
                    {last ? t("Begin") : t("Next")}
                </button>
                <Button words={t("Close")} onClick={() => (step.value = null)} />
            </div>
        </div>
    );
}
