import struct,subprocess,collections,re,sys
ELF='target/thumbv7em-none-eabihf/release/count'
data=open('target/profile/trace.bin','rb').read(); i=0; ticks=[]
while i<len(data):
    n,=struct.unpack_from('<I',data,i); i+=4; ticks.append(struct.unpack_from(f'<{n}I',data,i)); i+=4*n
nm=subprocess.run(['arm-none-eabi-nm','-S','-C',ELF],capture_output=True,text=True).stdout
fa={}
for l in nm.splitlines():
    m=re.match(r'(\w+) (\w+) [tT] (.*)',l)
    if m: fa[m.group(3)]=(int(m.group(1),16)&~1,int(m.group(2),16))
def f(sub): return next(v for k,v in fa.items() if k.endswith(sub))
target=f(sys.argv[1])
def has(t,r): return any(r[0]<=p<r[0]+r[1] for p in t)
sel=ticks
for w in sys.argv[2:]:
    neg=w[0]=='!'; r=f(w.lstrip('!'))
    sel=[t for t in sel if has(t,r)!=neg]
c=collections.Counter(p for t in sel for p in t)
d=subprocess.run(['arm-none-eabi-objdump','-d','-l','--no-show-raw-insn',f'--start-address={target[0]:#x}',f'--stop-address={target[0]+target[1]:#x}',ELF],capture_output=True,text=True).stdout
line=''
print(len(sel))
for l in d.splitlines():
    m=re.match(r'\s+([0-9a-f]+):\s+(.*)',l)
    if m:
        a=int(m.group(1),16)
        if c.get(a,0)>0.02*len(sel): print(f'{c[a]/len(sel):5.2f} {m.group(2).split("<")[0]:36s} {line}')
    elif ':' in l and '/' in l: line=l.split('/')[-2]+'/'+l.split('/')[-1]
