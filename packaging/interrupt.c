/* Runs a command on Windows and presses Ctrl-C when it has begun to write a file. Its exit code is that of the command.
 *
 *   interrupt PATTERN COMMAND ARGUMENT...
 *
 * PATTERN names the file that is begun, and may contain asterisks. Needs a console.
 */
#include <stdio.h>
#include <string.h>
#include <windows.h>

/* Ctrl-C is for all programs of the console; this one goes on. */
static BOOL WINAPI go_on(DWORD key)
{
    (void)key;
    return TRUE;
}

static int begun(const char *pattern)
{
    WIN32_FIND_DATAA found;
    HANDLE search = FindFirstFileA(pattern, &found);
    if (search == INVALID_HANDLE_VALUE) return 0;
    FindClose(search);
    return found.nFileSizeLow > 0;
}

int main(int count, char **arguments)
{
    char line[4096] = "";
    STARTUPINFOA start = {sizeof start};
    PROCESS_INFORMATION process;
    DWORD code = 1;
    for (int i = 2; i < count; i++) {
        if (strlen(line) + strlen(arguments[i]) + 4 > sizeof line) return 2;
        strcat(strcat(strcat(line, i > 2 ? " \"" : "\""), arguments[i]), "\"");
    }
    SetConsoleCtrlHandler(go_on, TRUE);
    if (!CreateProcessA(0, line, 0, 0, TRUE, 0, 0, 0, &start, &process)) return 2;
    while (!begun(arguments[1]) && WaitForSingleObject(process.hProcess, 100) == WAIT_TIMEOUT) {
    }
    if (!GenerateConsoleCtrlEvent(CTRL_C_EVENT, 0) || WaitForSingleObject(process.hProcess, 60000)) {
        TerminateProcess(process.hProcess, 3);
        return 3;
    }
    GetExitCodeProcess(process.hProcess, &code);
    return (int)code;
}
