/* Start of a program with semihosting on an emulated microcontroller: what a processor has of its own, and what all share. */

#ifndef NARX_TESTS_START_H
#define NARX_TESTS_START_H

/* Asks the emulator, by the instruction that it takes for that. */
int semihosting(int operation, void *block);

/* Calls main with the arguments that the emulator gives, once memory is initialised, and ends the program. */
void run_program(void);

#endif
