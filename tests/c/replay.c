/* Replays recordings with libnarx and prints a line for each:
 *
 *     STEM TICKS DIGEST RECORDED             the whole recording
 *     STEM TICKS DIGEST - OUTPUTS            its first N ticks (--ticks N), and what the last of them answered
 *     STEM error MESSAGE                     it cannot be replayed; exit code 1 after the others
 */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "narx.h"

/* 64-bit numbers by hand: not every small C library prints them. */

static void print_decimal(uint64_t value)
{
    char digits[21];
    size_t at = sizeof digits - 1;

    digits[at] = '\0';
    do {
        digits[--at] = (char)('0' + (int)(value % 10u));
        value /= 10u;
    } while (value != 0u);
    fputs(&digits[at], stdout);
}

static void print_hexadecimal(uint64_t value)
{
    char digits[17];
    size_t place;

    for (place = 0; place < 16u; place++) {
        digits[place] = "0123456789abcdef"[(value >> (60u - 4u * place)) & 15u];
    }
    digits[16] = '\0';
    fputs(digits, stdout);
}

/* The whole number in `text`, decimal. */
static int read_decimal(const char *text, uint64_t *value)
{
    *value = 0;
    if (*text == '\0') {
        return 0;
    }
    for (; *text != '\0'; text++) {
        if (*text < '0' || *text > '9' || *value > (UINT64_MAX - 9u) / 10u) {
            return 0;
        }
        *value = *value * 10u + (uint64_t)(*text - '0');
    }
    return 1;
}

/* The name of a file without directory and .narxrec. */
static void print_stem(const char *path)
{
    static const char ending[] = ".narxrec";
    const char *slash = strrchr(path, '/');
    const char *name = slash == NULL ? path : slash + 1;
    size_t length = strlen(name);
    size_t cut = sizeof ending - 1;

    if (length > cut && strcmp(name + length - cut, ending) == 0) {
        length -= cut;
    }
    printf("%.*s ", (int)length, name);
}

/* A file in memory of its own, or NULL. */
static uint8_t *read_file(const char *path, size_t *length)
{
    FILE *file = fopen(path, "rb");
    uint8_t *bytes = NULL;
    size_t room = 0;
    size_t got;

    if (file == NULL) {
        return NULL;
    }
    *length = 0;
    do {
        if (*length == room) {
            uint8_t *larger;

            room += 65536u;
            larger = realloc(bytes, room);
            if (larger == NULL) {
                free(bytes);
                fclose(file);
                return NULL;
            }
            bytes = larger;
        }
        got = fread(bytes + *length, 1, room - *length, file);
        *length += got;
    } while (got != 0);
    fclose(file);
    return bytes;
}

static int replay(const uint8_t *bytes, size_t length, const uint64_t *ticks)
{
    char text[NARX_OUTPUTS_TEXT_SIZE];
    narx_outcome_t outcome;
    narx_status_t status;

    text[0] = '\0';
    if (ticks == NULL) {
        status = narx_replay(bytes, length, &outcome);
    } else {
        status = narx_replay_until(bytes, length, *ticks, &outcome, text, sizeof text);
    }
    if (status == NARX_ERROR_KIND) {
        status = narx_replay_transcript(bytes, length, ticks == NULL ? UINT64_MAX : *ticks, &outcome);
        text[0] = '\0';
    } else if (status < 0 && ticks == NULL) {
        /* The words for what was just found: as far as that, and no further. */
        narx_replay_until(bytes, length, UINT64_MAX, &outcome, text, sizeof text);
    }
    if (status < 0) {
        printf("error %s\n", text[0] != '\0' ? text : narx_status_text(status));
        return 0;
    }
    print_decimal(outcome.ticks);
    putchar(' ');
    print_hexadecimal(outcome.digest);
    putchar(' ');
    if (ticks == NULL) {
        print_hexadecimal(outcome.recorded_digest);
        putchar('\n');
    } else {
        printf("- %s\n", text);
    }
    return 1;
}

int main(int argc, char **argv)
{
    uint64_t ticks = 0;
    int limited = 0;
    int good = 1;
    int first = 1;
    int at;

    if (argc > 1 && strcmp(argv[1], "--ticks") == 0) {
        limited = argc > 2 && read_decimal(argv[2], &ticks);
        first = 3;
    }
    if (argc <= first || (first == 3 && !limited)) {
        fputs("usage: replay [--ticks N] FILE...\n", stderr);
        return 2;
    }
    for (at = first; at < argc; at++) {
        size_t length = 0;
        uint8_t *bytes = read_file(argv[at], &length);

        print_stem(argv[at]);
        if (bytes == NULL) {
            puts("error cannot be read");
            good = 0;
        } else {
            good &= replay(bytes, length, limited ? &ticks : NULL);
        }
        free(bytes);
    }
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
