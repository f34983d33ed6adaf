/* CrowdMechanics(files): one TimeStep of a Trial, from XML files and back to them.
 *
 * The shared library is target/release/libcrowd_mechanics.so, or binaries/<platform>/CrowdMechanics.<so|dll|dylib> of any packed FMU.
 * For the FMI 2.0 functions of the same library use the standard's own headers.
 */
#ifndef CROWD_MECHANICS_H
#define CROWD_MECHANICS_H

#ifdef __cplusplus
extern "C" {
#endif

/* Reads the files, advances by one TimeStep, overwrites AgentDynamics.xml (without <Dynamics>), writes AgentInteractions.xml beside it
 * when there are contacts and removes it when there are none. Numbers are written so that they read back to the same double, so a
 * chain of calls equals one uninterrupted run.
 *
 * files: five names, each ending in a zero (on Windows in UTF-8):
 *   files[0]  Parameters.xml, a path from the working directory; the directories in it are relative to its own
 *   files[1]  Materials.xml      in the Static directory
 *   files[2]  Geometry.xml       in the Static directory
 *   files[3]  Agents.xml         in the Static directory
 *   files[4]  AgentDynamics.xml  in the Dynamic directory
 *
 * Nothing is kept between calls: files that changed are read again, and each call may name another directory. Calls from several threads
 * at once are fine as long as they do not share a Dynamic directory.
 *
 * Returns 0, or 1 after a message on standard error that names file, line, element, attribute and value; every file is then as it was.
 */
int CrowdMechanics(char **files);

#ifdef __cplusplus
}
#endif

#endif
