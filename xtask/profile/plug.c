#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
typedef uint64_t qemu_plugin_id_t; typedef struct qemu_info_t qemu_info_t;
struct qemu_plugin_tb; struct qemu_plugin_insn;
extern void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, void(*)(qemu_plugin_id_t, struct qemu_plugin_tb*));
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb*);
extern struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb*, size_t);
extern uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn*);
extern void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn*, void(*)(unsigned,void*), int, void*);
extern void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, void(*)(qemu_plugin_id_t,void*), void*);
__attribute__((visibility("default"))) int qemu_plugin_version = 1;
static uint64_t entry, lo, hi; static long first, last, tick=-1; static FILE*out;
static uint32_t buf[65536]; static uint32_t n; static int in;
static void flush(void){ if(in&&tick>=first&&tick<last){ fwrite(&n,4,1,out); fwrite(buf,4,n,out);} in=0; }
static void ex(unsigned c, void*u){ uint64_t pc=(uint64_t)(uintptr_t)u;
 if(pc==entry){ flush(); tick++; n=0; in=1; }
 if(in){ if(pc>=lo&&pc<hi){ if(n<65536) buf[n++]=pc; } } }
static void tb(qemu_plugin_id_t id, struct qemu_plugin_tb*t){ size_t k=qemu_plugin_tb_n_insns(t); for(size_t i=0;i<k;i++){ struct qemu_plugin_insn*s=qemu_plugin_tb_get_insn(t,i); uint64_t a=qemu_plugin_insn_vaddr(s); if(a==entry||(a>=lo&&a<hi)) qemu_plugin_register_vcpu_insn_exec_cb(s, ex, 0, (void*)(uintptr_t)a);} }
static void end(qemu_plugin_id_t id, void*p){ flush(); fclose(out); }
__attribute__((visibility("default"))) int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t*i, int argc, char**argv){
 for(int k=0;k<argc;k++){ char*e=strchr(argv[k],'='); if(!e) continue; *e++=0;
  if(!strcmp(argv[k],"entry")) entry=strtoul(e,0,0); else if(!strcmp(argv[k],"lo")) lo=strtoul(e,0,0); else if(!strcmp(argv[k],"hi")) hi=strtoul(e,0,0); else if(!strcmp(argv[k],"first")) first=atol(e); else if(!strcmp(argv[k],"last")) last=atol(e); else if(!strcmp(argv[k],"dump")) out=fopen(e,"wb"); }
 qemu_plugin_register_vcpu_tb_trans_cb(id,tb); qemu_plugin_register_atexit_cb(id,end,0); return 0; }
