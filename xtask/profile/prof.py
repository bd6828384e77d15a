#!/usr/bin/env python3
# prof.py MODE(hall|sensorless|path) first last [top]
import subprocess,sys,struct,collections,re,os
ELF='target/thumbv7em-none-eabihf/release/count'
mode=sys.argv[1]; first=int(sys.argv[2]); last=int(sys.argv[3]); top=int(sys.argv[4]) if len(sys.argv)>4 else 40
rec=f'target/running/{mode}.narxrec' if '/' not in mode else mode
nm=subprocess.run(['arm-none-eabi-nm','-n','-S',ELF],capture_output=True,text=True).stdout
funcs=[]
for l in nm.splitlines():
    p=l.split()
    if len(p)==4 and p[2] in 'tT': funcs.append((int(p[0],16)&~1,int(p[1],16),p[3]))
dem=subprocess.run(['arm-none-eabi-c++filt'],input='\n'.join(f[2] for f in funcs),capture_output=True,text=True).stdout.splitlines()
funcs=[(a,s,re.sub(r'::h[0-9a-f]{16}$','',d)) for (a,s,_),d in zip(funcs,dem)]
entry=[a for a,s,d in funcs if 'image' in d and d.endswith('::step')]
entry=[a for a,s,d in funcs if re.search(r'count::image::step$|5image4step',d)]
cor=[(a,s,d) for a,s,d in funcs if 'narx_core' in d or a==entry[0] or 'compiler_builtins' in d or '__aeabi' in d]
lo=min(a for a,s,d in cor); hi=max(a+s for a,s,d in cor)
f='target/profile/trace.bin'
name=os.path.basename(ELF)
args=['qemu-system-arm','-machine','mps2-an386','-display','none','-monitor','none','-serial','none','-chardev','stdio,id=semihosting,signal=off','-semihosting-config',f'enable=on,target=native,chardev=semihosting,arg={name},arg={rec}','-kernel',ELF,'-icount','shift=7,sleep=off','-plugin',f'target/profile/plug.so,entry={entry[0]:#x},lo={lo:#x},hi={hi:#x},first={first},last={last},dump={f}']
r=subprocess.run(args,stdin=subprocess.DEVNULL,capture_output=True,text=True)
print(r.stdout.splitlines()[0] if r.stdout else r.stderr[:500])
# parse
data=open(f,'rb').read(); i=0; ticks=[]
import bisect
starts=[a for a,s,d in funcs]
def fn(pc):
    k=bisect.bisect_right(starts,pc)-1
    a,s,d=funcs[k]; return d
entryend=entry[0]+[s for a,s,d in funcs if a==entry[0]][0]
while i<len(data):
    n,=struct.unpack_from('<I',data,i); i+=4
    pcs=struct.unpack_from(f'<{n}I',data,i); i+=4*n
    # cut at return: last pc within entry function after others
    cut=n
    for k in range(1,n):
        if entry[0]<=pcs[k]<entryend: cut=k+1
    # the step fn: entry.. ; find final contiguous
    # end when leaving: pcs after last entry-function pc are of others
    ticks.append(pcs[:cut])
tot=sum(len(t) for t in ticks)
print('ticks',len(ticks),'avg',tot/len(ticks),'worst',max(len(t) for t in ticks))
uniq=sorted({p for t in ticks for p in t})
al=subprocess.run(['arm-none-eabi-addr2line','-e',ELF,'-f','-i','-C','-a']+[hex(u) for u in uniq],capture_output=True,text=True).stdout if len(uniq)<6000 else ''
chain={}
cur=None
lines=al.splitlines()
j=0
while j<len(lines):
    if lines[j].startswith('0x'):
        cur=int(lines[j],16); chain[cur]=[]; j+=1
    else:
        func=lines[j]; loc=lines[j+1]; chain[cur].append((re.sub(r'::h[0-9a-f]{16}$','',func),loc.split('/')[-1].split(' ')[0])); j+=2
def short(x):
    x=x.replace('narx_core::motor::','').replace('<impl drive::Drive>::','').replace('drive::Drive','Drive')
    x=re.sub(r'drive::(\w+)::<impl narx_core::motor::drive::Drive>','Drive',x)
    return x
# kinds by set of out-of-line functions
kinds=collections.Counter(); ktot=collections.Counter()
for t in ticks:
    s=[]
    for p in t:
        d=short(fn(p)).split('::'); d='::'.join(d[-2:])
        if d not in s and 'image' not in d: s.append(d)
    k=' '.join(x for x in s if x!='Drive::step')
    kinds[k]+=1; ktot[k]+=len(t)
print('--- kinds'); 
for k,c in sorted(kinds.items(), key=lambda kc:-ktot[kc[0]])[:14]:
    print(f'{c/len(ticks)*100:5.1f}% avg {ktot[k]/c:7.1f}  share {ktot[k]/len(ticks):6.1f}  {k}')
flt=os.environ.get('KIND')
if flt:
    want=flt.split('&'); sel=[]
    for t in ticks:
        ds={short(fn(p)) for p in t}
        ok=True
        for w in want:
            neg=w.startswith('!'); w2=w.lstrip('!')
            has=any(w2 in d for d in ds)
            if has==neg: ok=False
        if ok: sel.append(t)
    ticks=sel
    print('selected',len(ticks),'avg',sum(map(len,ticks))/max(1,len(ticks)))
    oo=collections.Counter()
    for t in ticks:
        for p in t: oo[short(fn(p))]+=1
    print('--- out-of-line')
    for k,v in oo.most_common(20): print(f'{v/len(ticks):7.1f} {k}')
inl=collections.Counter(); incl=collections.Counter(); loc=collections.Counter()
for t in ticks:
    for p in t:
        ch=chain.get(p) or [(fn(p),'?')]
        names=[]
        for a,b in ch:
            nme=short(a); 
            if nme.startswith('core::') or '::fixed' in nme or nme.startswith('<'): continue
            names.append(nme)
        if not names: names=[short(ch[-1][0])]
        inl[names[0]]+=1
        for nme in set(names): incl[nme]+=1
        loc[ch[0][1] if 'library' not in ch[0][1] else ch[-1][1]]+=1
print('--- innermost function, per tick')
for k,v in inl.most_common(top): print(f'{v/len(ticks):7.1f}  incl {incl[k]/len(ticks):7.1f}  {k}')
if len(sys.argv)>5:
    print('--- lines')
    for k,v in loc.most_common(60): print(f'{v/len(ticks):7.2f} {k}')
