"""How the studio's page looks."""

STYLE = """
html, body { overflow: hidden !important; }
.studio { display: grid; grid-template-columns: 320px minmax(0, 1fr) 300px; height: 100vh; background: #f5f6f8;
  color: #1c2430; font-size: 14px; line-height: 1.4; }
.column { overflow-y: auto; padding: 14px 16px; background: #fff; }
.column.form { border-right: 1px solid #dde2e8; display: flex; flex-direction: column; padding-bottom: 0; }
.column.list { border-left: 1px solid #dde2e8; }
.brand { display: flex; align-items: baseline; gap: 8px; margin-bottom: 10px; }
.brand b { font: 600 17px ui-monospace, monospace; }
.quiet { color: #5a6675; font-size: 12.5px; }
.mono { font-family: ui-monospace, monospace; font-size: 12px; }
h2 { font-size: 14px; font-weight: 600; margin: 14px 0 6px; display: flex; gap: 8px; align-items: center; }
h2 .number { background: #17646b; color: #fff; border-radius: 50%; width: 20px; height: 20px; font-size: 12px;
  display: inline-flex; align-items: center; justify-content: center; flex: none; }
.row { display: flex; gap: 8px; align-items: center; }
.fields { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; margin-top: 8px; }
.fields.three { grid-template-columns: 1fr 1fr 1fr; }
.pick { display: block; text-align: center; padding: 7px 10px; border: 1px solid #17646b; border-radius: 4px;
  color: #17646b; font-weight: 500; cursor: pointer; }
.pick:hover { background: #eef5f5; }
.pick.small { padding: 4px 10px; font-size: 13px; }
form.upload { position: relative; }
form.upload input { position: absolute; inset: 0; opacity: 0; cursor: pointer; width: 100%; }
form.upload:focus-within .pick { outline: 2px solid #17646b; outline-offset: 2px; }
.opened { display: flex; gap: 8px; align-items: center; padding: 6px 10px; background: #eef5f5; border-radius: 4px;
  margin-top: 8px; overflow-wrap: anywhere; }
.method { display: block; padding: 7px 10px; border: 1px solid #dde2e8; border-radius: 4px; margin-bottom: 6px;
  cursor: pointer; }
.method:hover { border-color: #17646b; }
.method.chosen { border-color: #17646b; background: #eef5f5; }
.method input { accent-color: #17646b; margin-right: 8px; }
.method .quiet { display: block; padding-left: 21px; }
details { margin-top: 6px; } summary { cursor: pointer; color: #17646b; font-weight: 500; padding: 2px 0; }
.start { position: sticky; bottom: 0; background: #fff; padding: 12px 0 14px; margin-top: auto;
  border-top: 1px solid #eef0f3; z-index: 2; }
.middle { display: flex; flex-direction: column; min-width: 0; padding: 14px 18px; overflow-y: auto; }
.title { font-size: 19px; font-weight: 600; margin: 0; overflow-wrap: anywhere; }
.verdict { font-size: 24px; font-weight: 600; margin-right: 10px; }
.scene { position: relative; flex: 1 1 auto; min-height: 300px; margin-top: 10px; background: #fff;
  border: 1px solid #dde2e8; border-radius: 6px; overflow: hidden; }
.captions { position: absolute; inset: 0 0 auto 0; display: flex; pointer-events: none; z-index: 1; }
.captions > div { flex: 1; text-align: center; padding: 8px 6px 0; min-width: 0; }
.captions > div + div { border-left: 1px solid #eef0f3; }
.home { position: absolute; right: 8px; bottom: 8px; z-index: 1; }
.hint { position: absolute; left: 10px; bottom: 10px; z-index: 1; pointer-events: none; }
.welcome { margin: auto; max-width: 520px; }
.welcome ol { padding-left: 20px; } .welcome li { margin: 10px 0; }
.files { display: flex; flex-wrap: wrap; gap: 8px; margin-top: 10px; }
.files a { padding: 5px 12px; border: 1px solid #c4ccd6; border-radius: 4px; color: #1c2430; text-decoration: none;
  background: #fff; }
.files a.first { background: #17646b; border-color: #17646b; color: #fff; }
.files a:hover { border-color: #17646b; }
.wrong { background: #fdecea; border-left: 4px solid #c0392b; padding: 8px 12px; margin: 8px 0;
  overflow-wrap: anywhere; }
.warning { background: #fff6e0; border-left: 4px solid #d99a00; padding: 6px 12px; margin-top: 8px; font-size: 13px; }
.steps { display: flex; gap: 6px; margin-top: 6px; }
.steps span { padding: 2px 10px; border-radius: 10px; background: #e8ebef; font-size: 12.5px; color: #5a6675; }
.steps .done { background: #dcefe3; color: #1d6b3c; } .steps .running { background: #17646b; color: #fff; }
.steps .failed { background: #fdecea; color: #a93226; }
.stage { display: grid; grid-template-columns: 150px 1fr 44px; gap: 10px; align-items: center; margin-top: 5px; }
.bar { height: 6px; border-radius: 3px; background: #e8ebef; overflow: hidden; }
.bar > div { height: 100%; background: #17646b; transition: width .2s; }
.card { border: 1px solid #dde2e8; border-radius: 6px; padding: 9px 11px; margin-bottom: 8px; cursor: pointer;
  background: #fff; width: 100%; text-align: left; }
.card:hover { border-color: #17646b; } .card.chosen { border-color: #17646b; box-shadow: 0 0 0 1px #17646b; }
.card .name { font-weight: 500; overflow-wrap: anywhere; }
.state { font-size: 12px; padding: 1px 8px; border-radius: 9px; background: #e8ebef; color: #5a6675; flex: none; }
.state.running { background: #17646b; color: #fff; }
.state.failed { background: #fdecea; color: #a93226; }
.state.done { background: #dcefe3; color: #1d6b3c; }
.between { display: flex; justify-content: space-between; gap: 8px; align-items: center; }
.two-lines { display: -webkit-box; -webkit-line-clamp: 2; -webkit-box-orient: vertical; overflow: hidden; }
.log { max-height: 220px; overflow: auto; background: #f5f6f8; padding: 8px 10px; border-radius: 4px;
  white-space: pre-wrap; overflow-wrap: anywhere; }
table.scores { border-collapse: collapse; width: 100%; background: #fff; margin-top: 10px; font-size: 13px; }
table.scores th, table.scores td { text-align: right; padding: 4px 10px; border-bottom: 1px solid #eef0f3; }
table.scores th:first-child, table.scores td:first-child { text-align: left; font-weight: 400; }
table.scores td + td { font-family: ui-monospace, monospace; }
.picture { max-width: 100%; max-height: 460px; display: block; margin: 8px auto; }
.link { background: none; border: none; color: #17646b; cursor: pointer; padding: 0; font-size: 13px; }
.link:hover { text-decoration: underline; }
.v-btn { letter-spacing: 0 !important; font-weight: 500 !important; }
.v-input { flex: none !important; }
.card .verdict-line { white-space: nowrap; font-size: 13px; font-weight: 500; }
.v-field { font-size: 13px !important; } .v-messages { font-size: 11.5px !important; }
"""
