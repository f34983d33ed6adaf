/* Advances a Trial by so many TimeSteps, file to file.
 *
 *   cc examples/c/advance.c -Iinclude -Ltarget/release -lcrowd_mechanics -Wl,-rpath,target/release -o advance
 *   cp -r resources/Trial_push /tmp/Trial && ./advance /tmp/Trial/Parameters.xml 10
 */
#include "crowd_mechanics.h"

#include <stdio.h>
#include <stdlib.h>

int main(int count, char **arguments) {
    if (count != 3) {
        fprintf(stderr, "usage: %s PATH/Parameters.xml STEPS\n", arguments[0]);
        return 2;
    }
    char *files[] = {arguments[1], "Materials.xml", "Geometry.xml", "Agents.xml", "AgentDynamics.xml"};
    int steps = atoi(arguments[2]);
    for (int step = 0; step < steps; step++) {
        /* A controller would add <Dynamics Fp="x,y" Mp="z"/> to each agent of AgentDynamics.xml here. */
        if (CrowdMechanics(files) != 0) {
            return 1;
        }
    }
    printf("%d steps done\n", steps);
    return 0;
}
