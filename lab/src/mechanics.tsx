// Materials and steps of the scene, changed as numbers.

import { canChange, MOST } from "./forms";
import type { Film } from "./film";
import { inWords, t } from "./language";
import { Button, digits, Meanings, NumberField } from "./parts";
import { plan } from "./plan";
import type { Contact, Material2d, Mechanics, Scene } from "./protocol";
import { choose, playsOn } from "./session";

const NOTHING: Mechanics = { time_step: null, time_step_mechanical: null, materials: [], contacts: [] };
/** In s: longest communication step, shortest mechanical step; largest modulus in N/m, damping in kg/s, friction. The engine
 * has no such ends. */
const [LONGEST, SHORTEST, STIFFEST, MOST_DAMPING, MOST_FRICTION] = [10, 1e-9, 1e12, 1e9, 100];

function set(part: Partial<Mechanics>) {
    const next = { ...NOTHING, ...plan.value.made.mechanics, ...part };
    const none = JSON.stringify(next) === JSON.stringify(NOTHING);
    choose({ mechanics: none ? undefined : next }, playsOn());
}

/** The list with one part of one of them changed. What was changed just before may not be on the stage yet: it counts, not what is
 * shown. */
function changed<T>(all: T[] = [], shown: T, part: Partial<T>, same: (other: T) => boolean): T[] {
    return [...all.filter((other) => !same(other)), { ...(all.find(same) ?? shown), ...part }];
}

function setMaterial(shown: Material2d, part: Partial<Material2d>) {
    set({ materials: changed(plan.value.made.mechanics?.materials, shown, part, ({ id }) => id === shown.id) });
}

function setContact(shown: Mechanics["contacts"][number], part: Partial<Mechanics["contacts"][number]>) {
    set({ contacts: changed(plan.value.made.mechanics?.contacts, shown, part, ({ id1, id2 }) => id1 === shown.id1 && id2 === shown.id2) });
}

/** What is changed, in words: Young and shear modulus of materials, normal and tangential damping of pairs. */
export function moduli({ materials }: Mechanics): string[] {
    return materials.map(({ id, young_modulus, shear_modulus }) => t('"{id}": {young} and {shear} N/m', { id, young: young_modulus, shear: shear_modulus }));
}
export function dampings({ contacts }: Mechanics): string[] {
    return contacts.map(({ id1, id2, gamma_normal, gamma_tangential, kinetic_friction: friction }) => `${t('"{pair}": {normal} and {tangential} kg/s', { pair: `${id1} – ${id2}`, normal: gamma_normal, tangential: gamma_tangential })}${friction === null ? "" : `, ${t("friction {friction}", { friction })}`}`);
}

/** As `lemons check` says it, with the same limits. */
function stability({ mechanical_step: step, stable, longest, error }: Scene): string {
    const limits = { stable: digits(stable!, 2), longest: digits(longest!, 2) };
    if (step >= stable!) return t("The mechanical step is not stable. Stable up to {stable} s, without a warning up to {longest} s.", limits);
    const long = step > longest! ? `${t("The mechanical step is stable, but long.")} ` : "";
    return long + t("Stable up to {stable} s, without a warning up to {longest} s, accurate to about {error} mm.", { ...limits, error: digits(1000 * error!, 2) });
}

const TERMS = {
    young: t("E, the Young modulus in two dimensions (hence N/m): with G it gives the stiffness of a contact"),
    shear: t("G, the shear modulus in two dimensions (hence N/m): with E it gives the stiffness of a contact"),
    normal: t("Force per speed of approach: the larger, the more energy a collision loses"),
    tangential: t("Force per speed of slip: the larger, the more energy is lost while two disks stick"),
    friction: t("Two touching disks slide where the tangential force would exceed this multiple of the normal force"),
};
const NAMED: [string, string][] = [
    [t("Young modulus"), TERMS.young],
    [t("shear modulus"), TERMS.shear],
    [t("normal damping"), TERMS.normal],
    [t("tangential damping"), TERMS.tangential],
    [t("friction"), TERMS.friction],
];

/** Six digits of a bound are enough to read. */
const short = (bound: number) => Number(bound.toPrecision(6));

export function MechanicsForm({ film: { scene } }: { film: Film }) {
    const { made } = plan.value;
    const { mechanical_step, stable, longest, advised, warnings } = scene;
    // What was changed is in the fields at once; the scene follows.
    const own = made.mechanics ?? NOTHING;
    const materials = scene.materials.map((one) => own.materials.find(({ id }) => id === one.id) ?? one);
    const contacts = scene.contacts.map((one) => {
        const changed = own.contacts.find(({ id1, id2 }) => id1 === one.id1 && id2 === one.id2);
        return { ...one, ...changed, kinetic_friction: changed?.kinetic_friction ?? one.kinetic_friction };
    });
    const coarse = longest !== null && mechanical_step > longest;
    return (
        <div class="panel">
            <NumberField label={t("Communication step")} unit="s" value={own.time_step ?? scene.step} min={own.time_step_mechanical ?? mechanical_step} max={LONGEST} step={0.01} onChange={(time_step) => set({ time_step })} />
            <NumberField label={t("Mechanical step")} unit="s" value={own.time_step_mechanical ?? mechanical_step} min={SHORTEST} max={own.time_step ?? scene.step} step={1e-5} onChange={(time_step_mechanical) => set({ time_step_mechanical })} />
            {stable !== null && <p class={coarse ? "warning" : "note"}>{stability(scene)}</p>}
            {warnings.length > 0 && (
                <ul class="notes warning">
                    {warnings.map((warning) => (
                        <li key={warning.text}>{inWords(warning)}</li>
                    ))}
                </ul>
            )}
            <div class="buttons">
                {advised !== null && advised !== mechanical_step && (
                    <Button words={t("Take the advised step: {advised} s", { advised: short(advised) })} onClick={() => set({ time_step_mechanical: advised })} />
                )}
                {made.mechanics && (
                    <Button words={t("As the scene has them")} onClick={() => choose({ mechanics: undefined }, playsOn())} />
                )}
            </div>
            {materials.filter(({ id }) => canChange(id)).map((material) => (
                <fieldset key={material.id} class="fields">
                    <legend>{material.id}</legend>
                    <NumberField of={`"${material.id}"`} label={t("Young modulus")} unit="N/m" title={TERMS.young} value={material.young_modulus} min={1} max={short(4 * material.shear_modulus)} step={1e5} onChange={(young_modulus) => setMaterial(material, { young_modulus })} />
                    <NumberField of={`"${material.id}"`} label={t("shear modulus")} unit="N/m" title={TERMS.shear} value={material.shear_modulus} min={short(material.young_modulus / 4)} max={STIFFEST} step={1e5} onChange={(shear_modulus) => setMaterial(material, { shear_modulus })} />
                </fieldset>
            ))}
            {contacts.filter(({ id1, id2 }) => canChange(id1) && canChange(id2)).map((contact) => (
                <ContactFields key={`${contact.id1} ${contact.id2}`} contact={contact} />
            ))}
            {made.base.kind === "crowd" && <p class="note">{t("Each pair has its own numbers. The slider and the tab Crowd set the friction of all pairs with people.")}</p>}
            <Meanings of={NAMED} />
            {!materials.every(({ id }) => canChange(id)) && <p class="note">{t("Materials whose Ids have more than {most} letters cannot be changed here.", { most: MOST.name })}</p>}
        </div>
    );
}

function ContactFields({ contact }: { contact: Contact<number> }) {
    const { base } = plan.value.made;
    const { id1, id2 } = contact;
    const name = id1 === id2 ? id1 : `${id1} – ${id2}`;
    // Of a crowd, its form has the friction until that of a pair is changed.
    const ofForm = base.kind === "crowd" && [id1, id2].includes(base.material);
    const set = (part: Partial<Contact<number>>) => setContact({ ...contact, kinetic_friction: ofForm ? null : contact.kinetic_friction }, part);
    return (
        <fieldset class="fields">
            <legend>{name}</legend>
            <NumberField of={`"${name}"`} label={t("normal damping")} unit="kg/s" title={TERMS.normal} value={contact.gamma_normal} min={0} max={MOST_DAMPING} step={100} onChange={(gamma_normal) => set({ gamma_normal })} />
            <NumberField of={`"${name}"`} label={t("tangential damping")} unit="kg/s" title={TERMS.tangential} value={contact.gamma_tangential} min={0} max={MOST_DAMPING} step={100} onChange={(gamma_tangential) => set({ gamma_tangential })} />
            <NumberField of={`"${name}"`} label={t("friction")} title={TERMS.friction} value={contact.kinetic_friction} min={0} max={MOST_FRICTION} step={0.05} onChange={(kinetic_friction) => set({ kinetic_friction })} />
        </fieldset>
    );
}
