"""Small files as PsychoPy, jsPsych, E-Prime, Gorilla, OpenSesame, DMDX and Qualtrics write them, made up for
tests."""

from pathlib import Path

PSYCHOPY = """\ufefftrials.thisN,practice.thisN,instr_key.keys,instr_key.rt,corrAns,resp.keys,resp.corr,resp.rt,participant,psychopyVersion,
,,space,7.8,,,,,7,2026.2.5,
,0,,,left,left,1,0.61,7,2026.2.5,
0,,,,left,left,1,0.41,7,2026.2.5,
1,,,,right,left,0,0.52,7,2026.2.5,
2,,,,left,None,0,,7,2026.2.5,
3,,,,None,None,1,,7,2026.2.5,
4,,,,,,,,7,2026.2.5,
"""  # noqa: E501
GORILLA_1 = """Event Index,UTC Timestamp,Participant Private ID,Tree Node Key,Trial Number,Screen Name,Zone Name,Zone Type,Reaction Time,Response,Attempt,Correct,Timed Out,display
1,1,71,task-a,BEGIN TASK,,,,,,,,,
2,2,71,task-a,1,Screen 1,fixation,fixation,500.1,,,,,Trials
3,3,71,task-a,1,Screen 2,Zone2,response_keyboard,412.5,j,1,0,,Trials
4,4,71,task-a,1,Screen 2,Zone2,response_keyboard,912.5,f,2,1,,Trials
5,5,71,task-a,2,Screen 2,Zone2,response_keyboard,3000.2,,,0,1,Trials
6,6,71,task-a,3,Screen 2,Zone2,response_keyboard,501.5,j,1,1,,Practice
7,7,71,task-a,4,Screen 2,Zone2,response_keyboard,388.25,j,1,1,,Trials
END OF FILE,,,,,,,,,,,,,
"""  # noqa: E501
OPENSESAME = """"subject_nr","opensesame_version","practice","count_key","response_key","response_time_key","response_time_start","response_time","correct_key","correct"
"3","4.0.1","yes","0","z","611.2","2210.0","611.2","1","1"
"3","4.0.1","no","NA","NA","NA","2210.0","2210.0","undefined","undefined"
"3","4.0.1","no","1","z","402.5","2210.0","402.5","1","1"
"3","4.0.1","no","1","z","402.5","2210.0","402.5","1","1"
"3","4.0.1","no","2","m","377.1","2210.0","377.1","0","0"
"3","4.0.1","no","3","None","2000.4","2210.0","2000.4","0","0"
"""  # noqa: E501
DMDX = """Subjects incorporated to date: 002
Data file started on machine LAB4

**********************************************************************
Subject 1, 03/04/2026 10:11:12 on LAB4, refresh 16.67ms
  Item       RT
! the display was late at item 12
    11    543.21
    12   -612.40
    13  -2500.00
**********************************************************************
Subject 2, 03/04/2026 11:11:12 on LAB4, refresh 16.67ms, ID anna7
  Item       RT
    11    423.21
    12  -2500.00
"""
QUALTRICS = """StartDate,Status,Finished,ResponseId,Q1,T1_First Click,T1_Last Click,T1_Page Submit,T1_Click Count,T2_First Click,T2_Last Click,T2_Page Submit,T2_Click Count
Start Date,Response Type,Finished,Response ID,"What do you
think?",Timing - First Click,Timing - Last Click,Timing - Page Submit,Timing - Click Count,Timing - First Click,Timing - Last Click,Timing - Page Submit,Timing - Click Count
"{""ImportId"":""startDate""}","{""ImportId"":""status""}","{""ImportId"":""finished""}","{""ImportId"":""_recordId""}","{""ImportId"":""QID1""}","{""ImportId"":""QID2_FIRST_CLICK""}","{""ImportId"":""QID2_LAST_CLICK""}","{""ImportId"":""QID2_PAGE_SUBMIT""}","{""ImportId"":""QID2_CLICK_COUNT""}","{""ImportId"":""QID3_FIRST_CLICK""}","{""ImportId"":""QID3_LAST_CLICK""}","{""ImportId"":""QID3_PAGE_SUBMIT""}","{""ImportId"":""QID3_CLICK_COUNT""}"
2026-03-04 10:00:00,IP Address,True,R_1abc,good,0.812,1.5,2.25,2,0,0,3.5,0
2026-03-04 11:00:00,IP Address,True,R_2def,bad,1.012,1.5,2.75,2,,,,
2026-03-04 12:00:00,Survey Preview,True,R_3xyz,,1.1,1.1,1.9,1,1.2,1.2,2.0,1
"""  # noqa: E501
JSPSYCH = (
    '[{"rt":null,"stimulus":"+","response":null,"trial_type":"html-keyboard-response","trial_index":0},'
    '{"rt":431,"stimulus":"<p>go\u2028'
    ' left</p>","response":"f","trial_type":"html-keyboard-response","trial_index":1},'
    '{"rt":null,"stimulus":"+","response":null,"trial_type":"html-keyboard-response","trial_index":2},'
    '{"rt":null,"stimulus":"<p>go'
    ' right</p>","response":null,"trial_type":"html-keyboard-response","trial_index":3},'
    '{"rt":null,"stimulus":"+","response":null,"trial_type":"html-keyboard-response","trial_index":4},'
    '{"rt":9000,"stimulus":"?","response":{"Q0":"x"},"trial_type":"survey-text","trial_index":5}]'
)
EPRIME_LOG = """*** Header Start ***
LevelName: Session
LevelName: Block
LevelName: Trial
Experiment: simple
Subject: 21
*** Header End ***
	Level: 3
	*** LogFrame Start ***
	Procedure: TrialProc
	Stim.ACC: 1
	Stim.CRESP: {SPACE}
	Stim.RESP: {SPACE}
	Stim.RT: 340
	*** LogFrame End ***
Level: 2
*** LogFrame Start ***
Procedure: PracticeProc
*** LogFrame End ***
	Level: 3
	*** LogFrame Start ***
	Procedure: TrialProc
	Stim.ACC: 0
	Stim.CRESP: {SPACE}
	Stim.RESP:
	Stim.RT: 0
	*** LogFrame End ***
	Level: 3
	*** LogFrame Start ***
	Procedure: TrialProc
	Stim.ACC: 1
	Stim.CRESP:
	Stim.RESP:
	Stim.RT: 0
	*** LogFrame End ***
	Level: 3
	*** LogFrame Start ***
	Procedure: TrialProc
	Stim.ACC: 0
	Stim.CRESP: {SPACE}
	Stim.RESP: x
	Stim.RT: 512
	*** LogFrame End ***
Level: 2
*** LogFrame Start ***
Procedure: ExpProc
*** LogFrame End ***
Level: 1
*** LogFrame Start ***
Clock.Scale: 1
*** LogFrame End ***
"""
EPRIME_MERGED = """D:\\Lab\\all.emrg3
ExperimentName\tSubject\tSession\tProcedure[Block]\tStim.ACC\tStim.CRESP\tStim.RESP\tStim.RT
simple\t3\t1\tExpProc\t1\t1\t1\t401
simple\t3\t1\tExpProc\t0\t1\t2\t455
simple\t3\t1\tExpProc\t0\t1\t\t0
"""

FILES: dict[str, tuple[str, str, str]] = {
    "psychopy": ("P07_stroop.csv", PSYCHOPY, "utf-8"),
    "gorilla": ("data_exp_1-v7_task-a.csv", GORILLA_1, "utf-8"),
    "opensesame": ("subject-3.csv", OPENSESAME, "utf-8"),
    "dmdx": ("lexdec.azk", DMDX, "utf-8"),
    "qualtrics": ("survey.csv", QUALTRICS, "utf-8"),
    "jspsych": ("data.json", JSPSYCH, "utf-8"),
    "eprime": ("simple-21-1.txt", EPRIME_LOG, "utf-16"),
}
"""Preset to a file of its program: name, text, encoding."""


def made(folder: Path, preset: str) -> Path:
    """Write the file of a program and return its path."""
    name, text, encoding = FILES[preset]
    path = folder / name
    path.write_bytes(text.replace("\n", "\r\n").encode(encoding))
    return path
